# SPDX-License-Identifier: BSD-3-Clause
"""The topics that viewers of a recording ask for, with their types."""

TYPES = {
    "/voice_assist/utterance": "voice_assist/Utterance",
    "/voice_assist/mode": "voice_assist/Mode",
    "/rst_control/event": "rst_control/Event",
    "/rst_control/state": "rst_control/ControllerState",
    "/joint_states": "sensor_msgs/JointState",
    "/rst_control/trocar": "geometry_msgs/PointStamped",
    "/rst_control/markers": "visualization_msgs/MarkerArray",
    "/rst_control/preview": "visualization_msgs/MarkerArray",
    "/robot/tissue_markers": "visualization_msgs/MarkerArray",
    "/voice_assist/partial": "std_msgs/String",
    "/voice_assist/alarm": "voice_assist/Alarm",
    "/voice_assist/alarm_marker": "visualization_msgs/Marker",
    "/voice_assist/heard_marker": "visualization_msgs/Marker",
    "/robot/tension": "geometry_msgs/WrenchStamped",
    "/robot/scene/compressed": "sensor_msgs/CompressedImage",
    "/robot_description": "std_msgs/String",
    "/diagnostics": "diagnostic_msgs/DiagnosticArray",
    "/tf": "tf2_msgs/TFMessage",
    "/tf_static": "tf2_msgs/TFMessage",
}

# recorded where someone asked the simulator for a picture, or a first motion is to be confirmed
ON_REQUEST = {"/robot/scene/compressed", "/rst_control/preview"}
