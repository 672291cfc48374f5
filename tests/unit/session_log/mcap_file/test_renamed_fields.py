# SPDX-License-Identifier: BSD-3-Clause
"""Sessions that were recorded before fields of messages got their present names."""

import csv
from dataclasses import replace
from functools import cache

import pytest
from genpy.dynamic import generate_dynamic

from session_log.export.export import export_topics
from session_log.mcap_file.decoder import RENAMED_FIELDS, Decoder, MissingField
from session_log.report.session.extract import extract
from support.message_classes import SEPARATOR, definition_of, serialise
from support.story import Story, recording_of

FORMER = {
    "voice_assist/Utterance": """# One decision of the recogniser.
Header header
string transcript
string[] phrases
float32[] wer
string command
string reason
string nearest         # the command with the lowest WER, chosen or not
float32 confidence
string mode
string origin          # recognizer or spotter
bool early             # decided before the end of the utterance was confirmed
time speech_start
time speech_end
time decision
""",
    "rst_control/ControllerState": """Header header
string state           # standby, active, moving, stopping, halted or faulted
string phase
string command
bool active            # assistance has been activated by "hey robot"
bool halted
string halt_reason
bool tissue_held
float64 progress
float64 path_position
float64 path_speed
float64 rcm_error
float64 insertion
float64 tension
float64 tension_target
string last_refusal
""",
}
HEADER = SEPARATOR + "std_msgs/Header\n" + definition_of("std_msgs/Header")


DECODER = Decoder()


@cache
def former_class(datatype):
    return generate_dynamic(datatype, FORMER[datatype] + HEADER)[datatype]


def as_recorded_before(message):
    """The same message by the definition of its type that recordings made before carry."""
    datatype = message.source.datatype
    if datatype not in FORMER:
        return message
    former, present = former_class(datatype)(), DECODER.decode(message)
    for name in former.__slots__:
        setattr(former, name, getattr(present, RENAMED_FIELDS[datatype].get(name, name)))
    definition, digest = FORMER[datatype] + HEADER, former._md5sum
    source = replace(message.source, definition=definition, md5sum=digest)
    return message._replace(source=source, data=serialise(former))


@pytest.fixture(scope="module")
def readers(tmp_path_factory):
    """A session as recorded today, and the same as it would have been recorded before."""
    folder = tmp_path_factory.mktemp("renamed")
    messages = list(Story(duration=20.0, rate=20).build())
    before = [as_recorded_before(m) for m in messages]
    return recording_of(folder / "now.mcap", messages), recording_of(folder / "before.mcap", before)


def test_a_recording_made_before_gives_the_same_report_rows(readers, report_config):
    now, before = (extract(reader, report_config) for reader in readers)
    assert len(now.heard) > 3 and before.heard == now.heard
    assert before.states == now.states and before.phases == now.phases
    for column in now.controller.columns:
        assert before.controller[column] == pytest.approx(now.controller[column], nan_ok=True)
    assert not before.undecodable and not before.missing_fields


@pytest.mark.parametrize("datatype", FORMER)
def test_a_former_field_is_read_and_exported_under_its_present_name(readers, tmp_path, datatype):
    topic = {"voice_assist/Utterance": "/voice_assist/utterance"}.get(
        datatype, "/rst_control/state"
    )
    export_topics(readers[1], tmp_path, [topic], "/none", ("csv", "parquet"))
    with (tmp_path / f"{topic.strip('/').replace('/', '_')}.csv").open(encoding="utf-8") as file:
        columns = next(csv.reader(file))
    assert set(RENAMED_FIELDS[datatype].values()) <= set(columns)
    assert not set(RENAMED_FIELDS[datatype]) & set(columns)


def test_every_renamed_field_is_one_of_the_former_definition():
    for datatype, names in RENAMED_FIELDS.items():
        assert all(f" {former} " in FORMER[datatype] for former in names)


def test_a_field_that_was_not_recorded_is_refused_with_its_topic(readers, tmp_path, report_config):
    messages = [m for m in readers[1].messages() if m.source.topic == "/voice_assist/utterance"]
    without = FORMER["voice_assist/Utterance"].replace("string transcript\n", "") + HEADER
    short = generate_dynamic("voice_assist/Utterance", without)["voice_assist/Utterance"]()
    source = replace(messages[0].source, definition=without)
    message = messages[0]._replace(source=source, data=serialise(short))
    with pytest.raises(MissingField, match=r"/voice_assist/utterance: .* without 'transcript'"):
        Decoder().read(message, lambda content: content.transcript)
    found = extract(recording_of(tmp_path / "s.mcap", [message]), report_config)
    assert found.heard == []
    assert found.missing_fields == {
        "/voice_assist/utterance: voice_assist/Utterance was recorded without 'transcript'"
    }
