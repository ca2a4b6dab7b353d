"""Exudyn: thin ANCF plates of four nodes without curvature stiffness, generalized-alpha.

https://exudyn.readthedocs.io/en/latest/docs/RST/items/ObjectANCFThinPlate.html. Reduced integration is the one that its
authors give against membrane locking. Nine coordinates a node, as this program has.
"""

import exudyn as exu
import numpy as np
from exudyn.advancedUtilities import SystemEnergy
from exudyn.shells import AddSphericalJointToGround, ShellMesh
from exudyn.utilities import LoadMassProportional, MarkerBodyMass
from job import Loop, run
from sheet import DENSITY, DURATION, ENERGY_SCALE, GRAVITY, POISSON, SAMPLE_STEP, SIDE, THICKNESS, YOUNG, Grid, Recorder


def simulate(job: dict) -> dict:
    """job: scene, nx, ny, step (s), spectral_radius, reduced (0 or 1)."""
    loop = Loop()
    grid = Grid(job["nx"], job["ny"])
    recorder = Recorder(grid, grid.triangles)
    container = exu.SystemContainer()
    system = container.AddSystem()
    mesh = ShellMesh(
        vertices=[[0, 0, 0], [SIDE, 0, 0], [SIDE, SIDE, 0], [0, SIDE, 0]],
        numberOfElementsX=job["nx"],
        numberOfElementsY=job["ny"],
        youngsModulus=YOUNG,
        poissonsRatio=POISSON,
        density=DENSITY,
        thickness=THICKNESS,
    )
    mesh.CreateANCFThinPlateElements(system, useReducedOrderIntegration=job.get("reduced", 1))
    no_bending = exu.Matrix3DList()
    no_bending.Append(np.zeros((3, 3)))
    for element in mesh.elementNumbers:
        system.SetObjectParameter(element, "curvatureCoefficients", no_bending)
        marker = system.AddMarker(MarkerBodyMass(bodyNumber=element))
        system.AddLoad(LoadMassProportional(markerNumber=marker, loadVector=[0, 0, -GRAVITY]))
    flat = np.array([p[:2] for p in mesh.nodeReferencePositions])
    order = np.lexsort((flat[:, 1].round(9), flat[:, 0].round(9)))
    for vertex in np.flatnonzero(grid.held(job["scene"])):
        AddSphericalJointToGround(system, mesh.nodeNumbers[order[vertex]])
    system.Assemble()
    states = []

    def keep(system, time):
        if time > (len(states) - 1e-6) * SAMPLE_STEP:
            states.append(np.array(system.systemData.GetODE2Coordinates()))
        return True

    keep(system, 0.0)
    system.SetPostStepUserFunction(keep)
    settings = exu.SimulationSettings()
    integration = settings.timeIntegration
    integration.endTime = DURATION[job["scene"]]
    integration.numberOfSteps = round(DURATION[job["scene"]] / job["step"])
    integration.generalizedAlpha.spectralRadius = job["spectral_radius"]
    integration.newton.useModifiedNewton = True
    integration.verboseMode = 0
    settings.solution.file.write = False
    settings.linearSolver.solverType = exu.LinearSolverType.EigenSparse
    energy = SystemEnergy(system)  # without gravity
    lift = system.ComputeLinearizedSystem()[0] @ np.tile([0, 0, 1.0, 0, 0, 0, 0, 0, 0], len(flat))  # kg: a unit along z
    with loop:
        try:
            system.SolveDynamic(settings)
        except exu.SolverError as error:
            raise FloatingPointError(f"the solver stopped at {SAMPLE_STEP * len(states):.3f} s") from error
    for sample, q in enumerate(states):
        recorder.add(sample, q.reshape(-1, 9)[order, :3] + np.column_stack([grid.flat, np.zeros(len(flat))]))
    return {
        **recorder.result(),
        **loop.result(),
        "energy_drift": (sum(energy.ComputeSystemEnergies()[:2]) + GRAVITY * lift @ states[-1]) / ENERGY_SCALE,
        "steps": integration.numberOfSteps,
        "unknowns": len(states[0]),
        "version": exu.GetVersionString(),
    }


if __name__ == "__main__":
    run(simulate)
