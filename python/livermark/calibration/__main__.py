"""Fits the stiffness of every spring of a body to finite element solutions under random loads:

    python3 -m livermark.calibration BODY --output FILE

`livermark run --calibration FILE` reads what it writes.
"""
import argparse
import inspect
import sys
from typing import NoReturn

from livermark.calibration import calibrate
from livermark.calibration.files import COMMAND
from livermark.errors import InputError


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        raise InputError(f"{message}; see {COMMAND} --help")


def _options() -> argparse.ArgumentParser:
    default = {name: argument.default for name, argument in inspect.signature(calibrate).parameters.items()}
    parser = _Parser(prog=COMMAND, allow_abbrev=False, description=(
        "Fits the stiffness of every spring of a body to finite element solutions under random loads. `livermark run "
        "--calibration FILE` reads what it writes."))
    parser.add_argument("body", metavar="BODY", help="name of a body that ships, or path of a .toml or mesh file")
    parser.add_argument("--output", required=True, metavar="FILE", help="the file to write, or to continue")
    parser.add_argument("--law", default=default["law"], help="spring law to start from (%(default)s)")
    parser.add_argument("--constrained", default=default["constrained"], metavar="PATCH",
                        help="the patch where the body is constrained (%(default)s)")
    parser.add_argument("--loads", dest="num_loads", type=int, default=default["num_loads"], metavar="N",
                        help="number of loads; every fourth is left out of the fit, as a test (%(default)s)")
    parser.add_argument("--seed", type=int, default=default["seed"], metavar="N",
                        help="seed of the random loads (%(default)s)")
    parser.add_argument("--iterations", type=int, default=default["iterations"], metavar="N",
                        help="evaluations of the objective, earlier calls included; a multiple of 20 (%(default)s)")
    parser.add_argument("--penalty", type=float, default=default["penalty"], metavar="P",
                        help="weight of the mean square of ln(k / start) beside that of relative errors (%(default)s)")
    parser.add_argument("--young", dest="young_modulus", type=float, metavar="E",
                        help="Young's modulus of the first region [Pa]; others keep their ratio to it")
    parser.add_argument("--poisson", dest="poisson_ratio", type=float, metavar="NU", help="Poisson's ratio of every region")
    parser.add_argument("--restart", action="store_true", help="start again even if the file exists")
    return parser


def _tell(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


def main(arguments: list) -> int:
    try:
        print(calibrate(**vars(_options().parse_args(arguments)), report=_tell).table())
    except (InputError, ImportError) as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
