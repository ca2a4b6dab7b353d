"""The points of a study: values of its parameters, run by run."""

from collections.abc import Iterator
from itertools import product
from typing import Any

import numpy as np
from scipy.stats import norm, qmc

from .document import Parameter, Study


def points(study: Study) -> Iterator[tuple[Any, ...]]:
    """Values of the parameters, in their order, for each run; of a grid, those of the last parameter change first."""
    if study.sampling.kind == "latin_hypercube":
        sampler = qmc.LatinHypercube(d=len(study.parameter), seed=np.random.default_rng(study.sampling.seed))
        shares = sampler.random(study.sampling.count)
        columns = [_at(parameter, share) for parameter, share in zip(study.parameter, shares.T, strict=True)]
        return zip(*columns, strict=True)
    columns = [_listed(parameter) for parameter in study.parameter]
    return product(*columns) if study.sampling.kind == "grid" else zip(*columns, strict=True)


def _listed(parameter: Parameter) -> list[Any]:
    """All values of a parameter of a grid or a list."""
    if parameter.values is not None:
        return list(parameter.values)
    return _between(parameter, np.linspace(0.0, 1.0, parameter.count))


def _at(parameter: Parameter, shares: np.ndarray) -> list[Any]:
    """Values at the shares (n,), from 0 to 1, of a parameter's distribution."""
    if parameter.values is not None:
        places = np.minimum((shares * len(parameter.values)).astype(int), len(parameter.values) - 1)
        return [parameter.values[place] for place in places]
    if parameter.normal is not None:
        mean, deviation = parameter.normal
        return _rounded(parameter, norm.ppf(shares, mean, deviation))
    return _between(parameter, shares)


def _between(parameter: Parameter, shares: np.ndarray) -> list[Any]:
    low, high = parameter.range
    if parameter.scale == "log":
        found = low * (high / low) ** shares
    else:
        found = low + (high - low) * shares
    # the ends are met exactly
    return _rounded(parameter, np.where(shares == 1.0, high, found))


def _rounded(parameter: Parameter, values: np.ndarray) -> list[Any]:
    if parameter.integer:
        return [int(value) for value in np.rint(values)]
    # a spread of 12 digits is enough, and reads well in the table
    return [float(f"{value:.12g}") for value in values]
