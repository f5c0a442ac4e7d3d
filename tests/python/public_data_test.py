"""Readers of measurements that others have published."""
import hashlib
import math
import struct

import numpy
import pytest
from livermark.errors import InputError
from livermark.studies import public_data
from livermark.studies.public_data import NUM_BEADS, best_rotation, from_turning_point, main, read_motion_capture, truth_cube

NUM_MARKERS, NUM_FRAMES = 3, 4


def c3d():
    """A file of four frames from the eleventh on, with the parameters in the second block."""
    content = bytearray(2 * 512)
    content[0], content[1], content[512 + 3] = 2, 0x50, 84
    for offset, kind, value in ((2, "H", NUM_MARKERS), (6, "H", 11), (8, "H", 10 + NUM_FRAMES), (12, "f", -0.01), (16, "H", 3),
                                (20, "f", 100.0)):
        struct.pack_into("<" + kind, content, offset, value)
    for value in range(NUM_MARKERS * NUM_FRAMES):
        content += struct.pack("<4f", value, 0.5, -2.0, 0.001)
    return content


def read(folder, content):
    (folder / "motion.c3d").write_bytes(content)
    return read_motion_capture(folder / "motion.c3d")


def test_a_capture_has_points_frame_by_frame(tmp_path):
    capture = read(tmp_path, c3d())
    assert capture.frame_rate == 100.0 and capture.positions.shape == (NUM_FRAMES, NUM_MARKERS, 3)
    for frame in range(NUM_FRAMES):
        for marker in range(NUM_MARKERS):
            assert capture.positions[frame, marker].tolist() == [frame * NUM_MARKERS + marker, 0.5, -2.0]


@pytest.mark.parametrize("offset, kind, value, fault", [
    (1, "B", 0x51, "no C3D file"), (512 + 3, "B", 85, "Intel"), (12, "f", 0.01, "integers"), (4, "H", 8, "analog"),
    (8, "H", 65535, "ends before"), (8, "H", 3, "no frames"), (16, "H", 0, "ends before"), (2, "H", 0, "no points"),
    (0, "B", 0, "Intel"), (20, "f", math.nan, "rate"), (2 * 512 + 16 * 4, "f", math.nan, "point 1 was not seen in frame 1"),
    (2 * 512 + 16 * 5 + 12, "f", -1.0, "point 2 was not seen in frame 1")])  # -1 is how cameras say it
def test_a_capture_of_another_kind_or_with_damage_is_refused(tmp_path, offset, kind, value, fault):
    content = c3d()
    struct.pack_into("<" + kind, content, offset, value)
    with pytest.raises(InputError, match=f"motion.c3d: .*{fault}.*export"):
        read(tmp_path, content)


def test_a_capture_that_ends_early_is_refused(tmp_path):
    with pytest.raises(InputError, match="ends before"):
        read(tmp_path, c3d()[:-1])
    with pytest.raises(InputError, match="no C3D file"):
        read(tmp_path, b"frame,marker,x,y,z\n")


def test_a_motion_starts_at_its_turning_point_between_records():
    """Let go at the upper end at 0.1234 s, so at the lower one half a period later."""
    frequency, ratio, interval, delay = 4.3, 0.05, 0.01, 0.1234
    tau = 2.0 * math.pi

    def swing(time):
        return numpy.where(time < 0.0, 1.0, numpy.exp(-tau * frequency * ratio * time) * numpy.cos(tau * frequency * time))

    def motion(time):
        parts = [numpy.stack([0.001 * part * swing(time), 0.0 * time, -0.01 + 0.008 * abs(part) * swing(time)], axis=-1)
                 for part in (1.0, -0.5)]
        return numpy.stack(parts, axis=1)
    recording = motion(interval * numpy.arange(200) - delay)
    found = from_turning_point(recording - recording[0], 100, "test")  # displacements are from where a hand holds it
    assert found.shape == (100, 2, 3)
    lowest = 0.5 / frequency  # [s] after it is let go; damping moves it by less than a hundredth of a period
    expected = motion(lowest + interval * numpy.arange(100)) - recording[0]
    assert numpy.abs(found - expected).max() < 0.02 * 0.016
    assert found[0, 0, 2] < found[1, 0, 2]  # the lowest place
    assert found[0, 0, 2] == pytest.approx(-0.008 * (1.0 + math.exp(-0.5 * tau * ratio)), abs=0.02e-3)
    with pytest.raises(InputError, match="test.*190 records"):
        from_turning_point(recording - recording[0], 190, "test")


def test_the_best_rotation_is_the_one_that_was_made_and_no_reflection():
    points = numpy.random.default_rng(3).random((6, 3))
    angle = 0.3
    rotation = numpy.array([[math.cos(angle), -math.sin(angle), 0.0], [math.sin(angle), math.cos(angle), 0.0], [0.0, 0.0, 1.0]])
    assert numpy.allclose(best_rotation(points, points @ rotation.T + [1.0, 2.0, 3.0]), rotation, atol=1e-12)
    flat = points * [1.0, 1.0, 0.0]
    assert numpy.linalg.det(best_rotation(flat, flat * [1.0, -1.0, 1.0])) == pytest.approx(1.0, abs=1e-12)


def cube():
    """Lines of a cube of beads 10 mm apart that is pressed to 0.95, 0.9 and 0.8 of its height."""
    lines = ["Truth Cube,,", "i,j,k,x0,y0,z0,x1,y1,z1,x2,y2,z2,x3,y3,z3"]
    for i in range(1, 8):
        for j in range(1, 8):
            for k in range(1, 8):
                places = [f"{10 * i},{10 * j},{part * 10 * (8 - k):.2f}" for part in (1.0, 0.95, 0.9, 0.8)]
                lines.append(f"{i},{j},{k}," + ",".join(places))
    return lines


def read_cube(folder, lines):
    (folder / "beads.csv").write_text("\n".join(lines) + "\n")
    return truth_cube(folder / "beads.csv")


def test_a_cube_has_its_beads_and_moves_between_its_layers(tmp_path):
    found = read_cube(tmp_path, cube())
    assert len(found["markers"]) == NUM_BEADS and found["drives"].count("z_max") == found["drives"].count("z_min") == 49
    assert found["box"]["corner"] == pytest.approx([0.0, 0.0, 0.01]) and found["box"]["size"] == pytest.approx([0.08, 0.08, 0.06])
    positions = numpy.reshape(found["positions"], (-1, 3))
    for state, part in zip(found["state"], (0.95, 0.9, 0.8)):
        displacement = numpy.reshape(state["displacement"], (-1, 3))
        assert numpy.allclose(displacement, positions * [0.0, 0.0, part - 1.0], atol=1e-6)


@pytest.mark.parametrize("line, text, fault", [
    (1, "a,b,c", "no line i,j,k"), (5, "", "342 beads"), (5, "1,1,4,1,2", "line has 5 cells"), (5, "1,1,8", "line has 3 cells"),
    (2, "1,1,8" + ",1" * 12, "numbers from 1 to 7, and here is 8"), (3, "1,1,1" + ",1" * 12, "bead 1 1 1 occurs twice"),
    (3, "1,1,2,x" + ",1" * 11, "'x' in column 4 is not a finite number")])
def test_a_cube_of_another_kind_or_with_damage_is_refused(tmp_path, line, text, fault):
    lines = cube()
    lines[line] = text
    with pytest.raises(InputError, match=f"beads.csv.*{fault}"):
        read_cube(tmp_path, lines)


def test_a_cube_upside_down_is_refused(tmp_path):
    with pytest.raises(InputError, match="layer 1 is not above layer 7"):
        read_cube(tmp_path, [line if line[0] not in "1234567" else ",".join(
            [*line.split(",")[:2], str(8 - int(line.split(",")[2])), *line.split(",")[3:]]) for line in cube()])


def test_a_file_that_is_not_the_published_one_is_named_and_read(tmp_path, capsysbinary):
    read_cube(tmp_path, cube())
    file = tmp_path / "beads.csv"
    assert main("truth_cube", str(file), str(file), hashlib.sha256(file.read_bytes()).hexdigest()) == 0
    assert b"is not the published file" not in capsysbinary.readouterr().out
    assert main("truth_cube", str(file), str(file), "0" * 64, str(tmp_path / "not_there.csv"), "0" * 64) == 0
    out = capsysbinary.readouterr().out
    assert out.count(b"is not the published file") == 1 and b"beads.csv is not" in out


def test_ten_tests_of_a_cylinder_have_a_mean_and_a_deviation(tmp_path):
    folder = tmp_path / "EF10_75T"
    folder.mkdir()
    for number, test in enumerate(public_data.TESTS):
        rows = "".join(f"{0.1 * k},{0.2 * k},{(1.0 + 0.01 * number) * 0.2 * k}\n" for k in range(201))
        (folder / f"EF10_75T_{test}.csv").write_text(f"a sample\nCompression test;\nTime (s),Compression (mm),Load (N)\n{rows}")
    made = public_data.ecoflex_cylinder(folder)
    force = made["state"][0]["force"]
    assert force["way"] == [0.0015, 0.003, 0.006, 0.01, 0.015]
    assert force["force"] == pytest.approx([1.045 * 1e3 * way for way in force["way"]])
    assert force["deviation"] == pytest.approx([0.01 * math.sqrt(110.0 / 12.0) * 1e3 * way for way in force["way"]])
    assert made["material"]["laws"]["ogden"] == [5.7802]
    assert not any("summary" in sentence for sentence in made["assumptions"])


def test_a_summary_of_cylinders_is_named(tmp_path):
    file = tmp_path / "EF30_0T.csv"
    file.write_text("# mean of ten\ncompression_mm,load_N,standard_deviation_N\n0,0,0\n20,40,0.4\n")
    made = public_data.ecoflex_cylinder(file)
    assert made["state"][1]["force"]["force"] == pytest.approx([3.0, 6.0, 12.0, 20.0, 30.0])
    assert "laws" not in made["material"] and any("summary" in sentence for sentence in made["assumptions"])
    file.write_text("compression_mm,load_N,standard_deviation_N\n0,0,0\n5,40,0.4\n")
    with pytest.raises(InputError, match="not known"):
        public_data.ecoflex_cylinder(file)
    file.write_text("strain,stress\n0,0\n")
    with pytest.raises(InputError, match="no line with compression_mm"):
        public_data.ecoflex_cylinder(file)
