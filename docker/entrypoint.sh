#!/bin/bash
# SPDX-License-Identifier: BSD-3-Clause
# Runs a command in the image with the workspace sourced: make demo, roslaunch voice_assist system.launch, session_log info ..., bash
cd /voice_assist || exit 1
. catkin_ws/devel/setup.bash
VOICE_ASSIST_COMMIT=$(cat .commit)
export VOICE_ASSIST_COMMIT
case "$*" in *demo* | *launch* | *paper* | *film* | *recorder*)
    mountpoint -q sessions ||
        echo "NOT KEPT: recordings go with this container. Start it with -v \"\$PWD/sessions:/voice_assist/sessions\"" >&2
    ;;
esac
exec "$@"
