"""Lines of the table that `verify` prints."""

import textwrap

from .convergence import Convergence

HEADING = (
    f"{'value':<34} {'mesh':<28} {'elements':>8} {'expected':>13} {'obtained':>13} {'rel. error':>10} "
    f"{'tolerance':>9} {'order':>5} {'extrapolated':>13} {'s':>6}"
)
WIDTH = len(HEADING)


def case_lines(case: Convergence) -> list[str]:
    """A case: its name and source, and a line per value and mesh; what misses its tolerance is marked."""
    lines = ["", *textwrap.wrap(f"{case.name}: {case.source}", WIDTH, subsequent_indent="    ")]
    for k, claim in enumerate(case.claims):
        errors = case.errors(k)
        for i, level in enumerate(case.levels):
            last = i == len(case.levels) - 1
            order, extrapolated = (case.order(k), case.extrapolated(k)) if last else (None, None)
            tolerance = claim.tolerances[i]
            mark = "  MISSED" if case.holds(k, i) is False else ""
            lines.append(
                f"{claim.name if i == 0 else '':<34} {level.label:<28} {level.elements or '':>8} {claim.exact:13.8g} "
                f"{level.obtained[k]:13.8g} {errors[i]:10.1e} {_number(tolerance, '9.1e')} {_number(order, 'z5.2f')} "
                f"{_number(extrapolated, '13.8g')} {level.seconds:6.1f}{mark}"
            )
    lines += [f"at {level.label}: {remark}" for level in case.levels for remark in level.remarks]
    lines += [f"failed at {level.label}: {level.failure}" for level in case.levels if level.failure is not None]
    return lines


def _number(value: float | None, form: str) -> str:
    return " " * int(form.strip("z").split(".")[0]) if value is None else format(value, form)
