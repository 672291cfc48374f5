#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# Builds the image where no container daemon runs: Debian 12 by debootstrap as its base, buildah in a chroot. As root, with Debian's
# packages buildah and debootstrap. Run it before a release. From the repository's root:
#   docker/build_without_daemon.sh [OPTION_OF_BUILDAH...]                   # --build-arg TORCH=cpu, --volume FILE:FILE:ro ...
#   docker/build_without_daemon.sh run [COMMAND...]                         # `make demo`, with sessions/ kept
# MIRROR names another mirror of Debian's. The image's size is the last line.
set -eu
cd "$(dirname "$0")/.."
export STORAGE_DRIVER="${STORAGE_DRIVER:-vfs}" BUILDAH_ISOLATION=chroot
BASE=docker.io/library/debian:12

root='' container='' # to be removed at the end, also after Ctrl-C
tidy() {
    [ -z "$root" ] || rm -rf "$root"
    [ -z "$container" ] || buildah rm "$container" >/dev/null
}
trap tidy EXIT
trap 'exit 130' INT TERM # without it dash runs no trap of EXIT

if [ "${1:-}" = run ]; then
    shift
    [ $# -gt 0 ] || set -- make demo
    mkdir -p sessions
    container=$(buildah from --pull-never localhost/voice_assist)
    buildah run --volume "$PWD/sessions:/voice_assist/sessions" "$container" -- docker/entrypoint.sh "$@"
    exit
fi

if ! buildah inspect --type image "$BASE" >/dev/null 2>&1; then
    root=$(mktemp -d)
    debootstrap --variant=minbase bookworm "$root" ${MIRROR:+"$MIRROR"}
    rm -f "$root"/var/cache/apt/archives/*.deb
    container=$(buildah from scratch)
    buildah add --quiet "$container" "$root" / >/dev/null
    buildah commit --quiet --rm "$container" "$BASE" >/dev/null
    container=''
fi
buildah bud --layers=false --pull-never --build-arg COMMIT="$(git rev-parse HEAD)" "$@" \
    --file docker/Dockerfile --tag localhost/voice_assist .
container=$(buildah from --pull-never localhost/voice_assist)
folder=$(buildah mount "$container") # on a line of its own, as in a pipe its failure would pass
size=$(du -sb "$folder")
echo "$size" | awk '{ printf "%.0f MB\n", $1 / 1e6 }'
