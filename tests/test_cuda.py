"""CUDA: kernels compile for it, nothing relies on memory that host and device share, energies are those of the CPU."""

import importlib
import pkgutil

import numpy as np
import pytest
import warp as wp
from warp_origami.kernels import linear, srm
from warp_origami.kernels.membrane import membrane_kernels

import warp_origami as origami
from warp_origami import kernels
from warp_origami.terms.buffers import Buffer

ARCHITECTURE = 75
"""Turing: the oldest that present CUDA supports."""

STEPS = 100


@pytest.fixture
def cuda():
    if not wp.is_cuda_available():
        pytest.skip("no CUDA device")
    return "cuda:0"


def kernel_modules():
    found = []
    for module in pkgutil.iter_modules(kernels.__path__):
        for item in vars(importlib.import_module(f"{kernels.__name__}.{module.name}")).values():
            if isinstance(item, wp.Kernel):
                found.append(item.module)
    found += [membrane_kernels(law).gradient.module for law in (srm, linear)]
    return {module.name: module for module in found}


@pytest.mark.parametrize("name", sorted(kernel_modules()))
def test_every_kernel_compiles_for_cuda(name, tmp_path):
    """To PTX, which needs the compiler that comes with Warp and no device."""
    paths = wp.compile_aot_module(kernel_modules()[name], arch=ARCHITECTURE, module_dir=tmp_path, use_ptx=True)
    text = "".join(path.read_text() for path in tmp_path.rglob("*.ptx"))
    assert paths
    assert all(f"{key}_" in text for key in kernel_modules()[name].kernels)


def energies(scene, **options):
    history = origami.simulate(scene, **options).history
    return {key: history[key] for key in ("kinetic_energy", "strain_energy", "contact_energy")}


def falling_strips():
    return origami.load_scene("hard/crossing_strips", ["integrator.step=2e-4"])


def spinning_sail():
    """Springs, hub and sunlight: what shares the memory of the element tangents, or adds to them."""
    material = {"density": 1420.0, "youngs_modulus": 2.5e9, "poisson_ratio": 0.34, "thickness": 7.5e-6}
    return origami.Scene(
        name="sail",
        analysis={"kind": "dynamic", "duration": 0.02},
        pattern={"kind": "sheet", "nx": 3, "ny": 2, "creases_x": [1, 2], "opening": 1.5},
        material=material,
        hub={"at": {"near": [0.0, 0.0]}, "mass": 1.0, "axial_inertia": 0.1},
        crease=[{"stiffness": 1e-3, "rest_angle": 0.5}],
        load=[{"kind": "solar", "direction": [1, 0, -1], "value": 1.0}, {"kind": "initial_spin", "rate": 1.0}],
        integrator={"step": 2e-3},
    )


@pytest.mark.parametrize("make", [falling_strips, spinning_sail])
def test_nothing_relies_on_memory_that_host_and_device_share(monkeypatch, make):
    """As on CUDA, what is read is a copy, and what is written to it changes nothing."""
    scene, until = make(), 0.02
    expected = energies(scene, device="cpu", until=until)
    made = Buffer.__init__

    def apart(self, shape, dtype, device):
        made(self, shape, dtype, device)
        self._view = None

    monkeypatch.setattr(Buffer, "__init__", apart)
    monkeypatch.setattr(Buffer, "read", lambda self: self.array.numpy().copy())
    found = energies(scene, device="cpu", until=until)
    assert expected["contact_energy" if make is falling_strips else "strain_energy"].max() > 0.0
    for key, values in expected.items():
        assert np.array_equal(found[key], values), key


@pytest.mark.cuda
@pytest.mark.parametrize("name", ["leaf_in", "swinging_sheet", "hard/crossing_strips"])
def test_cuda_gives_the_energies_of_the_cpu(name, cuda):
    """1e-9 of the largest energy over the first fixed steps."""
    step = {"leaf_in": 1e-3, "swinging_sheet": 1e-3, "hard/crossing_strips": 2e-4}[name]
    scene = origami.load_scene(name, [f"integrator.step={step}"])
    host, device = (energies(scene, device=where, until=STEPS * step) for where in ("cpu", cuda))
    largest = sum(host.values()).max()
    for key, values in host.items():
        np.testing.assert_allclose(device[key], values, rtol=0.0, atol=1e-9 * largest, err_msg=key)


@pytest.mark.cuda
def test_cuda_repeats_its_results_bitwise(cuda):
    first, again = (energies(falling_strips(), device=cuda, until=0.02) for _ in range(2))
    for key, values in first.items():
        assert np.array_equal(values, again[key]), key
