"""Numbers and tables as the program prints them."""
from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import NamedTuple

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


def significant(value: float, digits: int) -> str:
    return "-" if math.isnan(value) else f"{value:.{digits}g}"


def printable(text: str) -> str:
    """The same without control characters, which a terminal would obey."""
    return re.sub("[\x00-\x1f\x7f-\x9f]", "?", text)


class Column(NamedTuple):
    title: str
    is_number: bool = False


@dataclass(frozen=True)
class Table:
    columns: list[Column]
    rows: list[list[str]]

    def text(self) -> str:
        """Lines of equal columns, numbers to the right."""
        lines = [[printable(cell) for cell in row] for row in [[column.title for column in self.columns], *self.rows]]
        widths = [max(map(len, cells)) for cells in zip(*lines)]
        lines.insert(1, ["-" * width for width in widths])
        return "".join("  ".join(cell.rjust(width) if column.is_number else cell.ljust(width)
                                 for column, cell, width in zip(self.columns, line, widths)) + "\n" for line in lines)

    def markdown(self) -> str:
        def line(cells: list[str]) -> str:
            return "".join("| " + printable(cell).replace("|", "\\|") + " " for cell in cells) + "|\n"
        rule = "".join("| ---: " if column.is_number else "| --- " for column in self.columns) + "|\n"
        return line([column.title for column in self.columns]) + rule + "".join(map(line, self.rows))
