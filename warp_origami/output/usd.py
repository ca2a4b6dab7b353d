"""animation.usdc: the drawn sheet, its creases, its element corners and a camera that sees the whole motion."""

import errno
from pathlib import Path

import numpy as np
from pxr import Gf, Sdf, Tf, Usd, UsdGeom, Vt

from warp_origami.errors import InputError
from warp_origami.machine import machine
from warp_origami.model.submesh import Submesh
from warp_origami.scene import Scene
from warp_origami.solve.records import Frame

from .camera import View
from .colours import colour
from .files import replacing

STEPS_RATE = 1000.0
"""Time codes per second where every accepted step is a frame: a time code is then a millisecond."""

FIXED_RANGES = {"state": (0.0, 2.0)}
"""Colour ranges of fields whose values are known beforehand; those of other fields follow the run."""

PERCENTILES = (1.0, 99.0)
"""Of the values in a frame: a few elements with extreme stress should not take all the colours."""

PROBED = 1 << 20
"""Bytes that are written after USD could not write, to see what is in the way."""

LOCAL = ("contact_pressure",)
"""Fields that vanish but on small parts of the sheet: the percentiles are of the values there."""

CREASE_POINTS = "sheetPoints"
"""Attribute of the creases: the points of the sheet that they go through."""

MACHINE = "machine"
"""Key of the layer's customLayerData: what the run ran on, for whoever reads the file later and elsewhere."""


class Animation:
    """The animation while it grows; `save` writes all frames so far.

    The file has one `UsdGeomMesh` named sheet, `UsdGeomBasisCurves` named creases, `UsdGeomPoints` named nodes (corners
    of the elements in the order of the mesh's vertices; purpose guide, so that viewers do not draw them) and a camera.
    Fields are float primvars of the sheet; displayColor shows the first of them over a range that is the same in all
    frames and is written into its customData.
    """

    def __init__(self, path: Path, scene: Scene, surface: Submesh, resumed_at: float | None):
        """An empty animation; with `resumed_at` the frames of the file up to that time (s) are kept.

        Raises:
            InputError: the file is missing or cannot be read.
        """
        self.path = path
        self.surface = surface
        self.fields = scene.output.fields
        self.rate = STEPS_RATE if scene.output.fps == "steps" else scene.output.fps
        self._codes: list[float] = []
        self._view = View()
        self._range = (np.inf, -np.inf)  # of the first field, over all frames
        self._coloured: tuple[tuple[float, float], int] = (self._range, 0)  # range and number of frames already done
        self._normals = _Normals(surface.triangles, len(surface.flat))
        if resumed_at is not None:
            self._stage = Usd.Stage.Open(_opened(path, self._code(resumed_at)))
            self._find_prims()
            self._recall()
        else:
            self._stage = Usd.Stage.CreateInMemory("animation.usdc")
            self._define_prims()
        self._stage.GetRootLayer().customLayerData = {MACHINE: machine()}

    def add(self, frame: Frame) -> None:
        """Adds a frame; times are increasing."""
        code = self._code(frame.time)
        points = frame.points.astype(np.float32)
        self._sheet.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy(points), code)
        self._sheet.GetNormalsAttr().Set(Vt.Vec3fArray.FromNumpy(self._normals(frame.points)), code)
        self._sheet.GetExtentAttr().Set(_extent(points), code)
        nodes = frame.nodes.astype(np.float32)
        self._nodes.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy(nodes), code)
        self._nodes.GetExtentAttr().Set(_extent(nodes, self._line_width / 2), code)
        if self._creases:
            along = points[self.surface.creases.ravel()]
            self._creases.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy(along), code)
            self._creases.GetExtentAttr().Set(_extent(along, self._line_width / 2), code)
        for name in self.fields:
            values = np.asarray(frame.fields[name], dtype=np.float32)
            UsdGeom.PrimvarsAPI(self._sheet).GetPrimvar(name).Set(Vt.FloatArray.FromNumpy(values), code)
        shown = frame.fields[self.fields[0]].astype(np.float32) if self.fields else None  # as it can be read again
        self._take_account(code, points, shown)

    def save(self) -> None:
        """Replaces the file by one with all frames so far; does nothing before the first frame.

        Raises:
            OSError: the file cannot be written.
        """
        if not self._codes:
            return
        self._stage.SetStartTimeCode(self._codes[0])
        self._stage.SetEndTimeCode(self._codes[-1])
        self._place_camera()
        if self.fields:
            self._colour_frames()
        with replacing(self.path) as temporary:
            try:
                written = self._stage.GetRootLayer().Export(str(temporary))
            except Tf.ErrorException:  # USD's only way to say what is wrong
                written = False
            if not written:
                _refuse(temporary)

    def _code(self, time: float) -> float:
        """Time code of a time; the k-th frame has time code k in spite of round-off."""
        code = time * self.rate
        return float(round(code)) if abs(code - round(code)) < 1e-6 else code

    def _define_prims(self) -> None:
        stage, surface = self._stage, self.surface
        stage.SetTimeCodesPerSecond(self.rate)
        stage.SetFramesPerSecond(self.rate)
        UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
        UsdGeom.SetStageMetersPerUnit(stage, 1.0)
        stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/World").GetPrim())

        sheet = UsdGeom.Mesh.Define(stage, "/World/sheet")
        sheet.CreateFaceVertexCountsAttr(Vt.IntArray(len(surface.triangles), 3))
        sheet.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(surface.triangles.astype(np.int32).ravel()))
        sheet.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
        sheet.CreateDoubleSidedAttr(True)
        sheet.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
        primvars = UsdGeom.PrimvarsAPI(sheet)
        st = primvars.CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.vertex)
        st.Set(Vt.Vec2fArray.FromNumpy(surface.flat.astype(np.float32)))
        for name in self.fields:
            primvars.CreatePrimvar(name, Sdf.ValueTypeNames.FloatArray, UsdGeom.Tokens.vertex)
        if self.fields:
            sheet.CreateDisplayColorPrimvar(UsdGeom.Tokens.vertex)
        else:
            sheet.CreateDisplayColorPrimvar(UsdGeom.Tokens.constant).Set([Gf.Vec3f(0.6)])

        nodes = UsdGeom.Points.Define(stage, "/World/nodes")
        nodes.CreatePurposeAttr(UsdGeom.Tokens.guide)
        nodes.CreateWidthsAttr([self._line_width])
        nodes.SetWidthsInterpolation(UsdGeom.Tokens.constant)
        if len(surface.creases):
            creases = UsdGeom.BasisCurves.Define(stage, "/World/creases")
            creases.CreateTypeAttr(UsdGeom.Tokens.linear)
            creases.CreateCurveVertexCountsAttr(Vt.IntArray(*surface.creases.shape))
            creases.CreateWidthsAttr([self._line_width])
            creases.SetWidthsInterpolation(UsdGeom.Tokens.constant)
            creases.CreateDisplayColorPrimvar(UsdGeom.Tokens.constant).Set([Gf.Vec3f(0.02)])
            through = creases.GetPrim().CreateAttribute(CREASE_POINTS, Sdf.ValueTypeNames.IntArray)
            through.SetVariability(Sdf.VariabilityUniform)
            through.Set(Vt.IntArray.FromNumpy(surface.creases.ravel()))
        UsdGeom.Camera.Define(stage, "/World/camera")
        self._find_prims()

    def _find_prims(self) -> None:
        self._sheet = UsdGeom.Mesh.Get(self._stage, "/World/sheet")
        self._nodes = UsdGeom.Points.Get(self._stage, "/World/nodes")
        self._creases = UsdGeom.BasisCurves.Get(self._stage, "/World/creases")
        self._camera = UsdGeom.Camera.Get(self._stage, "/World/camera")

    @property
    def _line_width(self) -> float:
        """Drawn width of creases, m."""
        return 0.002 * float(np.linalg.norm(np.ptp(self.surface.flat, axis=0)))

    def _recall(self) -> None:
        """Takes account of the frames that an earlier part of the run has written."""
        primvars = UsdGeom.PrimvarsAPI(self._sheet)
        for code in self._sheet.GetPointsAttr().GetTimeSamples():
            values = np.asarray(primvars.GetPrimvar(self.fields[0]).Get(code)) if self.fields else None
            self._take_account(code, np.asarray(self._sheet.GetPointsAttr().Get(code)), values)

    def _take_account(self, code: float, points: np.ndarray, values: np.ndarray | None) -> None:
        self._codes.append(code)
        self._view.include(points)
        if values is None:
            return
        shown = values[np.isfinite(values)]
        if self.fields[0] in LOCAL and shown.any():
            shown = shown[shown != 0.0]
        if len(shown):
            low, high = np.percentile(shown, PERCENTILES)
            self._range = (min(self._range[0], float(low), 0.0), max(self._range[1], float(high)))

    def _colour_frames(self) -> None:
        """displayColor of the frames that do not have it over the present range."""
        name = self.fields[0]
        limits = FIXED_RANGES.get(name, self._range)
        done = self._coloured[1] if self._coloured[0] == limits else 0
        values = UsdGeom.PrimvarsAPI(self._sheet).GetPrimvar(name)
        shown = self._sheet.GetDisplayColorPrimvar()
        for code in self._codes[done:]:
            shown.Set(Vt.Vec3fArray.FromNumpy(colour(np.asarray(values.Get(code)), *limits)), code)
        shown.GetAttr().SetCustomData({"field": name, "low": limits[0], "high": limits[1]})
        self._coloured = (limits, len(self._codes))

    def _place_camera(self) -> None:
        camera = Gf.Camera()
        camera.SetPerspectiveFromAspectRatioAndFieldOfView(
            self._view.aspect, self._view.field_of_view, Gf.Camera.FOVVertical
        )
        camera.transform = Gf.Matrix4d(self._view.transform().tolist())
        near, far = self._view.distances()
        camera.focusDistance = 0.5 * (near + far)
        camera.clippingRange = Gf.Range1f(0.1 * near, 2.0 * far)
        self._camera.SetFromCamera(camera, Usd.TimeCode.Default())


class _Normals:
    """Unit normals of the points: means of the triangles around them, weighted by area."""

    def __init__(self, triangles: np.ndarray, count: int):
        self.triangles = triangles
        self.count = count
        self.some_triangle = np.zeros(count, dtype=int)
        self.some_triangle[triangles] = np.arange(len(triangles))[:, None]

    def __call__(self, points: np.ndarray) -> np.ndarray:
        """(count, 3) float32."""
        a, b, c = (points[self.triangles[:, k]] for k in range(3))
        of_triangles = np.cross(b - a, c - a)
        corners = self.triangles.ravel()
        weights = np.repeat(of_triangles, 3, axis=0).T
        normals = np.stack([np.bincount(corners, weights=w, minlength=self.count) for w in weights], axis=1)
        length = np.linalg.norm(normals, axis=1)
        # on a crease that is folded flat the two sides cancel: take one of them
        cancelled = length < 1e-6 * np.linalg.norm(of_triangles[self.some_triangle], axis=1)
        normals[cancelled] = of_triangles[self.some_triangle[cancelled]]
        length = np.linalg.norm(normals, axis=1)
        normals[length == 0.0] = (0.0, 0.0, 1.0)
        return (normals / np.where(length == 0.0, 1.0, length)[:, None]).astype(np.float32)


def _extent(points: np.ndarray, margin: float = 0.0) -> Vt.Vec3fArray:
    return Vt.Vec3fArray.FromNumpy(np.stack([points.min(axis=0) - margin, points.max(axis=0) + margin]))


def _refuse(path: Path) -> None:
    """Raises the OSError for which a file could not be written, which USD does not tell."""
    with path.open("ab") as file:
        file.write(bytes(PROBED))
    raise OSError(errno.EIO, "USD cannot write", str(path))


def _opened(path: Path, last: float) -> Sdf.Layer:
    """A copy in memory of an animation without the samples after time code `last`."""
    try:
        layer = Sdf.Layer.OpenAsAnonymous(str(path))
    except Tf.ErrorException:  # USD's only way to say what is wrong
        layer = None
    if layer is None:
        raise InputError("--resume", f"{path} that cannot be read", "the animation that this program wrote")
    for prim in [prim for root in layer.rootPrims for prim in [root, *root.nameChildren]]:
        for attribute in prim.attributes:
            for code in layer.ListTimeSamplesForPath(attribute.path):
                if code > last:
                    layer.EraseTimeSample(attribute.path, code)
    return layer


def read_nodes(path: Path) -> list[tuple[float, np.ndarray]]:
    """Time (s) and positions (nv, 3) float32, m, of the element corners in each frame of an animation.

    Raises:
        InputError: it cannot be read or is none of ours.
    """
    try:
        stage = Usd.Stage.Open(str(path))
    except Tf.ErrorException:
        stage = None
    nodes = UsdGeom.Points.Get(stage, "/World/nodes") if stage is not None else None
    if not nodes:
        raise InputError(str(path), "no animation with nodes", "the animation that this program wrote")
    rate = stage.GetTimeCodesPerSecond()
    points = nodes.GetPointsAttr()
    return [(code / rate, np.array(points.Get(code), dtype=np.float32)) for code in points.GetTimeSamples()]
