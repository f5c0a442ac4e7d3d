"""Statistics over the bodies of a cohort."""
import math
import os
import pathlib
import shutil

import h5py
import numpy
import pytest
from livermark.studies import cohort
from livermark.studies.cohort import Error, half_of, quantile, statistics_of

SAMPLES = pathlib.Path(os.environ["LIVERMARK_SAMPLES"])
SHIPPED = pathlib.Path(os.environ["LIVERMARK_SOURCE_DIR"]) / "results" / "cohorts"
FELT = 0.07


def error_of(body, load_case, relative_l2, **others):
    return Error(body, "small", 0.0, load_case, "springs", True, relative_l2, math.nan, "")._replace(**others)


def rows(statistics):
    return cohort.table(statistics, FELT).rows


def test_quantiles_are_interpolated_between_sorted_values():
    assert quantile([3.0, 1.0, 2.0], 0.5) == 2.0 and quantile([4.0, 1.0, 2.0, 3.0], 0.5) == 2.5
    assert quantile([0.0, 10.0], 0.95) == 9.5 and quantile([7.0], 0.95) == 7.0


def test_random_numbers_are_those_of_the_64_bit_mersenne_twister():
    """The 10000th number of the default seed, as the C++ standard has it ([rand.predef])."""
    assert int(cohort.random_numbers(5489, 10000)[-1]) == 9981545732273789042


def test_the_statistic_is_inside_its_interval_which_is_always_the_same():
    values = [float(i) for i in range(1, 22)]
    low, high = cohort.bootstrap_interval(values, 0.5)
    assert 5.0 <= low < 11.0 < high <= 17.0  # the order statistics 6 and 16 hold the median of 21 values with 97 %
    assert cohort.bootstrap_interval(values, 0.5) == (low, high)
    assert cohort.bootstrap_interval([0.25], 0.5) == (0.25, 0.25)


def test_odd_numbers_are_the_tuning_half_and_even_ones_the_test_half():
    assert half_of("liver_variant_7") == "training" and half_of("liver_variant_10") == "unseen"
    assert half_of("liver_healthy") is None and half_of("") is None


def test_the_mean_over_load_cases_is_taken_then_the_median_over_the_bodies_of_each_half():
    training, unseen = statistics_of([error_of("b_1", "pull", 0.1), error_of("b_1", "push", 0.3), error_of("b_3", "pull", 0.4),
                                      error_of("b_3", "push", 0.6), error_of("b_2", "pull", 0.7), error_of("b_2", "push", 0.9)])
    assert training.half == "training" and unseen.half == "unseen"
    assert training.median == pytest.approx(0.35, rel=1e-15)
    assert training.percentile_95 == pytest.approx(0.2 + 0.95 * 0.3, rel=1e-15) and training.worst == 0.5
    assert unseen.median == pytest.approx(0.8, rel=1e-15) and unseen.left_out == 0


def test_few_bodies_have_no_interval():
    errors = [error_of(f"b_{2 * i - 1}", "pull", 0.01 * i, stiffness=-0.01 * i) for i in range(1, 6)]
    few, = statistics_of(errors)
    assert math.isnan(few.median_interval[0]) and math.isnan(few.percentile_95_interval[1])
    assert math.isnan(few.stiffness_median_interval[0])
    assert rows([few])[0][5:7] == ["3.00", "4.80"] and rows([few])[0][9] == "3.0"
    five_have_a_tool, = statistics_of([*errors, error_of("b_11", "pull", 0.06)])
    assert math.isnan(five_have_a_tool.stiffness_median_interval[0])
    enough, = statistics_of([*errors, error_of("b_11", "pull", 0.06, stiffness=0.06)])
    assert enough.median_interval[0] < enough.median
    assert rows([enough])[0][5].startswith("3.50 (") and rows([enough])[0][9].startswith("3.5 (")


def test_errors_against_two_references_are_apart():
    refined = error_of("b_1", "pull", 0.2, reference="fem_p2p1_refined", stiffness=0.3)
    on_mesh = error_of("b_1", "pull", 0.1, reference="fem_p2p1", stiffness=-0.05)
    stopped = error_of("b_3", "pull", math.nan, is_ok=False)  # the reference found nothing there
    first, second = statistics_of([refined, on_mesh, stopped])
    assert (first.reference, first.median, first.stiffness_median, first.left_out) == ("fem_p2p1", 0.1, 0.05, 0)
    assert (second.reference, second.median, second.stiffness_median) == ("fem_p2p1_refined", 0.2, 0.3)
    assert second.left_out == 1  # beside the first that there was


def test_bodies_without_a_load_case_or_an_end_are_left_out():
    statistics = statistics_of([error_of("b_1", "pull", 0.1), error_of("b_1", "push", 0.3), error_of("b_3", "pull", 0.4),
                                error_of("b_5", "pull", 0.1), error_of("b_5", "push", 0.2, is_ok=False)])
    assert len(statistics) == 1 and statistics[0].errors == [0.2] and statistics[0].left_out == 2
    assert rows(statistics)[0][4] == "2"


def test_the_mean_size_of_stiffness_is_over_the_load_cases_that_have_one():
    """Of absolute values: too soft under one load case and too stiff under another is not right in the mean."""
    cases = [("b_1", "pull", 0.1), ("b_1", "push", 0.3), ("b_1", "hang", 0.3), ("b_3", "pull", 0.4), ("b_3", "push", 0.6),
             ("b_3", "hang", 0.6)]
    assert rows(statistics_of([error_of(*case) for case in cases]))[0][9] == "-"
    stiffness = (-0.1, 0.2, math.nan, 0.05, 0.05, math.nan)
    statistics = statistics_of([error_of(*case, stiffness=value) for case, value in zip(cases, stiffness)])
    assert statistics[0].sizes[0] == pytest.approx(0.15, rel=1e-15)
    assert statistics[0].stiffness_median == pytest.approx(0.1, rel=1e-15)
    assert rows(statistics)[0][9:11] == ["10.0 !", "15.0 !"]


def test_the_bar_of_the_reference_is_the_mean_over_load_cases_and_the_median_over_bodies():
    """Of the stiffness over load cases with a tool; a body with a load case of unknown uncertainty says nothing."""
    cases = [("b_1", "pull", 0.001, 0.01), ("b_1", "hang", 0.003, math.nan), ("b_3", "pull", 0.004, 0.02),
             ("b_3", "hang", 0.006, math.nan), ("b_5", "pull", math.nan, math.nan), ("b_5", "hang", 0.2, math.nan)]
    statistics, = statistics_of([error_of(body, case, 0.1, stiffness=math.nan if case == "hang" else 0.1, uncertainty=bar,
                                          stiffness_uncertainty=of_tool) for body, case, bar, of_tool in cases])
    assert statistics.uncertainty == pytest.approx(0.0035, rel=1e-15)
    assert statistics.stiffness_uncertainty == pytest.approx(0.015, rel=1e-15)
    row = rows([statistics])[0]
    assert (row[8], row[11]) == ("0.35", "1.5") and row[3] == "3"
    assert rows(statistics_of([error_of("b_1", "pull", 0.1)]))[0][8] == "-"


def test_regimes_are_apart_and_without_a_body_there_is_no_number():
    large = error_of("b_1", "large_pull", math.nan, regime="large", is_ok=False)
    first, second = statistics_of([large, error_of("b_1", "pull", 0.1)])
    assert first.median == 0.1 and second.regime == "large" and second.left_out == 1 and math.isnan(second.median)
    assert rows([second])[0][3:] == ["0", "1"] + ["-"] * 7


@pytest.mark.parametrize("name", ["livers_5000", "livers_16000", "livers_16000_large"])
def test_files_that_ship_have_the_statistics_of_their_errors(tmp_path, name):
    shutil.copy(SHIPPED / f"{name}.h5", tmp_path / "cohort.h5")
    cohort.finish(tmp_path / "cohort.h5")
    with h5py.File(SHIPPED / f"{name}.h5") as shipped, h5py.File(tmp_path / "cohort.h5") as made:
        assert set(shipped["statistics"]) == set(made["statistics"])
        for column, values in shipped["statistics"].items():
            again = made["statistics"][column]
            assert values.dtype == again.dtype
            assert numpy.array_equal(values[:], again[:], equal_nan=values.dtype.kind == "f"), column
            assert list(values.attrs.get("names", [])) == list(again.attrs.get("names", []))
        assert set(shipped) == set(made)


def test_a_cohort_without_errors_has_empty_statistics(tmp_path):
    with h5py.File(SAMPLES / "sample_cohort.h5") as sample, h5py.File(tmp_path / "cohort.h5", "w") as file:
        cohort.put_statistics(file, [])
        assert set(file["statistics"]) == set(sample["statistics"])
        assert all(len(values) == 0 for values in file["statistics"].values())
