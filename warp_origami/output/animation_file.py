"""Reading back the animation of a run."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pxr import Sdf, Tf, Usd, UsdGeom

from warp_origami.errors import InputError

from .usd import CREASE_POINTS, MACHINE


@dataclass(frozen=True)
class DrawnFrame:
    """The drawn sheet at one time.

    Attributes:
        points: (np, 3) float32, m.
        fields: name -> (np,) float32.
    """

    points: np.ndarray
    fields: dict[str, np.ndarray]


class AnimationFile:
    """animation.usdc as it was written; frames are read one by one.

    Attributes:
        times: (nf,) of the frames, s (static: load factor; modal: see solve.modal).
        triangles: (nt, 3) points of each drawn triangle.
        flat: (np, 2) flat coordinates, m.
        creases: (nc, k) points along each crease; empty where the file does not tell.
        fields: names of what is known at the points, first the one that the file's colours show.
        machine: what the run ran on; empty where the file does not tell.
    """

    def __init__(self, path: Path):
        """Opens the file.

        Raises:
            InputError: it is no animation of this program, or damaged.
        """
        try:
            # a layer of its own: by its path an earlier file might be found that is still open
            stage = Usd.Stage.Open(Sdf.Layer.OpenAsAnonymous(str(path)))
            sheet = UsdGeom.Mesh.Get(stage, "/World/sheet")
            self._points = sheet.GetPointsAttr()
            self._codes = self._points.GetTimeSamples()
            self.times = np.array(self._codes) / stage.GetTimeCodesPerSecond()
            self.triangles = np.asarray(sheet.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)
            primvars = UsdGeom.PrimvarsAPI(sheet)
            self.flat = np.asarray(primvars.GetPrimvar("st").Get())
            shown = sheet.GetDisplayColorAttr().GetCustomData().get("field")
            found = {primvar.GetPrimvarName(): primvar for primvar in primvars.GetPrimvarsWithValues()}
            names = sorted(found.keys() - {"st", "displayColor"}, key=lambda name: (name != shown, name))
            self._fields = {name: found[name] for name in names}
            self.creases = _creases(UsdGeom.BasisCurves.Get(stage, "/World/creases"))
            self.machine = dict(stage.GetMetadata("customLayerData").get(MACHINE, {}))
            self._stage = stage  # attributes do not keep it alive
        except (Tf.ErrorException, RuntimeError, TypeError, ValueError) as error:
            raise InputError(str(path), f"not readable ({_last_line(error)})", "an animation of this program") from None
        self.fields = tuple(self._fields)
        self._check(path)

    def _check(self, path: Path) -> None:
        count = len(self.flat)
        whole = self.flat.shape == (count, 2) and len(self._codes) > 0
        for numbers in (self.triangles, self.creases):
            whole = whole and (numbers.size == 0 or (numbers.min() >= 0 and numbers.max() < count))
        if not whole:
            raise InputError(str(path), "a sheet that is not complete", "an animation of this program")

    def frame(self, number: int) -> DrawnFrame:
        """A frame, numbered from 0.

        Raises:
            InputError: what is stored does not fit the sheet.
        """
        code, count = self._codes[number], len(self.flat)
        try:
            points = np.asarray(self._points.Get(code), dtype=np.float32)
            fields = {name: np.asarray(value.Get(code), dtype=np.float32) for name, value in self._fields.items()}
        except (Tf.ErrorException, RuntimeError, TypeError, ValueError) as error:
            raise InputError("animation.usdc", f"a damaged frame ({_last_line(error)})", "a whole file") from None
        if points.shape != (count, 3) or any(values.shape != (count,) for values in fields.values()):
            raise InputError("animation.usdc", "a damaged frame", f"{count} points")
        return DrawnFrame(points, fields)

    def frames(self, numbers: np.ndarray) -> Iterator[DrawnFrame]:
        """Several frames."""
        return (self.frame(int(number)) for number in numbers)


def _creases(curves: UsdGeom.BasisCurves) -> np.ndarray:
    """(nc, k) numbers of the points along the creases."""
    numbers = curves.GetPrim().GetAttribute(CREASE_POINTS) if curves else None
    if not numbers:
        return np.empty((0, 2), dtype=int)
    lengths = curves.GetCurveVertexCountsAttr().Get()
    return np.asarray(numbers.Get()).reshape(len(lengths), -1)


def _last_line(error: Exception) -> str:
    return str(error).strip().splitlines()[-1].strip() if str(error).strip() else type(error).__name__
