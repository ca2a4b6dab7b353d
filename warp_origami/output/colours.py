"""Colours of a scalar field: perceptually uniform, dark blue to yellow."""

import numpy as np

# viridis (S. van der Walt, N. Smith, CC0) at 17 equidistant places
VIRIDIS = np.array(
    [
        [0.267004, 0.004874, 0.329415],
        [0.282327, 0.094955, 0.417331],
        [0.278826, 0.175490, 0.483397],
        [0.258965, 0.251537, 0.524736],
        [0.229739, 0.322361, 0.545706],
        [0.199430, 0.387607, 0.554642],
        [0.172719, 0.448791, 0.557885],
        [0.149039, 0.508051, 0.557250],
        [0.127568, 0.566949, 0.550556],
        [0.120638, 0.625828, 0.533488],
        [0.157851, 0.683765, 0.501686],
        [0.246070, 0.738910, 0.452024],
        [0.369214, 0.788888, 0.382914],
        [0.515992, 0.831158, 0.294279],
        [0.678489, 0.863742, 0.189503],
        [0.845561, 0.887322, 0.099702],
        [0.993248, 0.906157, 0.143936],
    ]
)


def colour(values: np.ndarray, low: float, high: float) -> np.ndarray:
    """(n, 3) float32 linear RGB of n values; outside of low..high the end colours, values that are not finite grey."""
    span = high - low
    place = np.clip((values - low) / span, 0.0, 1.0) if span > 0.0 else np.zeros(len(values))
    knots = np.linspace(0.0, 1.0, len(VIRIDIS))
    srgb = np.stack([np.interp(place, knots, VIRIDIS[:, c]) for c in range(3)], axis=1)
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    linear[~np.isfinite(values)] = 0.2
    return linear.astype(np.float32)
