"""How numbers are written, as in the tables that the program prints."""
import math

PERCENT = 100.0
MILLIMETRES = 1e3
MILLISECONDS = 1e3


def fixed(value: float, decimals: int) -> str:
    """With some decimals; where that would be too wide, in the form 1.2e+34. "-" for NaN."""
    if math.isnan(value):
        return "-"
    return f"{value:.{decimals}f}" if abs(value) < 1e5 or not math.isfinite(value) else f"{value:.1e}"


def percent(value: float) -> str:
    return fixed(PERCENT * value, 2)


def mean(values: list[float]) -> float:
    return sum(values) / len(values)


def rounded_up(value: float) -> float:
    """The smallest of 1, 2 and 5 times a power of ten that is not below a value > 0."""
    power = 10.0 ** math.floor(math.log10(value))
    return next(step * power for step in (1.0, 2.0, 5.0, 10.0) if step * power >= value * (1.0 - 1e-9))
