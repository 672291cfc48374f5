# SPDX-License-Identifier: BSD-3-Clause
"""Joint states from a recorded session or a table, and the poses in which the robot rested."""

from __future__ import annotations

import csv
import json
import struct
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from mcap.exceptions import McapError
from mcap.reader import NonSeekingReader
from mcap.stream_reader import CRCValidationError
from mcap_ros1.decoder import DecoderFactory
from zstandard import ZstdError

from rst_control.errors import RstError
from rst_control.types import ARM_JOINTS, Vector, frozen_array
from typed_config import newest_recording

MCAP_MAGIC = b"\x89MCAP0\r\n"  # with which a file begins
JOINT_STATES = "sensor_msgs/JointState"
UNREADABLE_MCAP = (McapError, CRCValidationError, ZstdError, struct.error, EOFError)


class PoseFileError(RstError):
    """A file of joint states cannot be used."""

    def __init__(self, path: Path, words: str) -> None:
        super().__init__(f"{path}: {words}")
        self.path = path


@dataclass(frozen=True, eq=False)
class ArmSample:
    """The arm at one moment; the tool's joints do not move the shaft."""

    time: float  # [s] since the first sample
    position: Vector  # (7,), [rad]
    speed: float  # [rad/s] of the fastest joint; nan: not recorded


def read_arm(path: Path, topic: str) -> Iterator[ArmSample]:
    """Read the arm's joints in the order of the file.

    Args:
        path: An MCAP file, the folder of a session (its newest recording), or a CSV: as
            `session_log export` writes it, or with one column per joint [rad] and perhaps
            `time` [s].
        topic: Of the joint states, in an MCAP file.

    Raises:
        PoseFileError: The file is missing, damaged or holds something else.
    """
    recording = newest_recording(path)
    if recording is None and path.is_dir():
        raise PoseFileError(path, "no recording in this folder")
    path = recording or path
    start: float | None = None
    try:
        samples = _read_csv(path) if path.suffix == ".csv" else _read_mcap(path, topic)
        for time, names, position, velocity in samples:
            start = time if start is None else start
            yield ArmSample(time - start, _arm(names, position), _speed(names, velocity))
    except OSError as error:
        raise PoseFileError(path, error.strerror or repr(error)) from error
    except UNREADABLE_MCAP as error:
        raise PoseFileError(path, _unreadable(path)) from error
    except KeyError as error:
        raise PoseFileError(path, f"no joint states: {error} is missing") from error
    except (ValueError, TypeError) as error:
        raise PoseFileError(path, f"no joint states: {error}") from error
    if start is None:
        raise PoseFileError(path, f"no joint states on {topic}")


def rest_poses(
    samples: Iterable[ArmSample],
    apart: float,
    at_rest_speed: float,
    span: tuple[float, float] = (0.0, np.inf),
) -> list[ArmSample]:
    """Poses in which the arm rested, each once.

    Args:
        samples: In order of time.
        apart: Least change of a joint from the pose before [rad].
        at_rest_speed: Joints up to this speed rest [rad/s]; infinite: take poses in motion, too.
        span: First and last time [s] that count.
    """
    poses: list[ArmSample] = []
    for sample in samples:
        if not span[0] <= sample.time <= span[1] or sample.speed > at_rest_speed:
            continue
        if not poses or np.abs(sample.position - poses[-1].position).max() >= apart:
            poses.append(sample)
    return poses


Row = tuple[float, Sequence[str], Sequence[float], Sequence[float]]  # time, names, [rad], [rad/s]


def _unreadable(path: Path) -> str:
    with path.open("rb") as file:
        if file.read(len(MCAP_MAGIC)) != MCAP_MAGIC:
            return "neither a .csv nor an MCAP file"
    return "no whole MCAP file; `session_log recover` mends a recording that was cut short"


def _read_mcap(path: Path, topic: str) -> Iterator[Row]:
    with path.open("rb") as file:
        reader = NonSeekingReader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        decoded = reader.iter_decoded_messages([topic], log_time_order=False)
        for schema, _, _, message in decoded:
            if schema is None or schema.name != JOINT_STATES:
                found = schema.name if schema else "of no type"
                raise TypeError(f"{topic} is {found}, allowed: {JOINT_STATES}")
            stamp: Any = message.header.stamp
            yield stamp.secs + stamp.nsecs * 1e-9, message.name, message.position, message.velocity


def _read_csv(path: Path) -> Iterator[Row]:
    with path.open(newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            if "position" in row:  # as `session_log export` writes it
                stamp = float(row["header.stamp"])
                yield (
                    stamp,
                    json.loads(row["name"]),
                    json.loads(row["position"]),
                    json.loads(row["velocity"]),
                )
            else:
                yield (
                    float(row.get("time", 0.0)),
                    ARM_JOINTS,
                    [float(row[n]) for n in ARM_JOINTS],
                    (),
                )


def _arm(names: Sequence[str], position: Sequence[float]) -> Vector:
    known = dict(zip(names, position, strict=True))
    return frozen_array([known[name] for name in ARM_JOINTS], len(ARM_JOINTS))


def _speed(names: Sequence[str], velocity: Sequence[float]) -> float:
    if len(velocity) != len(names):
        return float("nan")
    return max(abs(v) for name, v in zip(names, velocity, strict=True) if name in ARM_JOINTS)
