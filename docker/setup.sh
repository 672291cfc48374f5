#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# Sets the project up, one part per call: check | system FILE | python FILE | fetch FOLDER | javascript | workspace | install PREFIX. `make` and docker/Dockerfile call
# the same parts.
# FILE lists packages: of Debian (docker/apt-*.txt) or of Python (requirements*.txt).
# Every part can be interrupted and run again; a part with nothing to do says so by saying nothing.
set -eu
cd -P "$(dirname "$0")/.." # the place itself, as make and Python name it, not a link to it
SYSTEM_ROOT=${SYSTEM_ROOT:-} # where the tests keep another system's files
PYTHON=$SYSTEM_ROOT/usr/bin/python3 # Debian's own: rospy and PyKDL belong to it, whatever other python comes first on PATH
CONTAINER="docker build -f docker/Dockerfile -t voice_assist . && docker run --rm voice_assist"
unset PYTHONPATH PYTHONHOME VIRTUAL_ENV MAKEFLAGS MAKELEVEL || true
export PYTHONNOUSERSITE=1 # packages under ~/.local would come before Debian's: an empy 4 there breaks the messages' generators

say() { printf '\n== %s\n' "$*"; }
fail() {
    printf '%s\n' "$*" >&2
    exit 1
}

# What nothing can be set up without, in one line each, before anything is installed or written.
machine() {
    release=$SYSTEM_ROOT/etc/os-release
    found=$(sh -c '. "$0" && printf %s "$ID $VERSION_ID"' "$release" 2>/dev/null) || found="a system without /etc/os-release"
    [ "$found" = "debian 12" ] || fail "This project runs on Debian 12, and this is $found. In a container it runs elsewhere: $CONTAINER"
    [ "$(dpkg --print-architecture)" = amd64 ] ||
        fail "This project runs on x86-64 (amd64) only, and this is $(dpkg --print-architecture). In a container, emulated: \
export DOCKER_DEFAULT_PLATFORM=linux/amd64; $CONTAINER"
    # on a bare Debian 12 there is none yet, and its own is 3.11
    [ ! -e "$PYTHON" ] || "$PYTHON" -c 'import sys; sys.exit(sys.version_info[:2] != (3, 11))' ||
        fail "$PYTHON is $("$PYTHON" --version), not the 3.11 of Debian 12. In a container nothing changes it: $CONTAINER"
    plain_path "$PWD" "This folder"
}

# plain_path PATH NAME: catkin, roslaunch and make take a path apart at spaces and signs.
plain_path() {
    case "$1" in *[!A-Za-z0-9/._+@~,=-]*)
        fail "$2 has a space, a quotation mark or another sign in its path that ROS takes apart: $1. Move it, or use a container: $CONTAINER" ;;
    esac
}

system_packages() {
    wanted=$(grep -v '^#' "$1")
    missing=
    for package in $wanted; do
        status=$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null || true)
        [ "$status" = installed ] || missing="$missing $package"
    done
    [ -n "$missing" ] || return 0
    announce
    say "Debian packages of $1 to install:$missing"
    line="apt-get install -y --no-install-recommends$missing"
    if [ "$(id -u)" = 0 ]; then
        sudo=
    elif command -v sudo >/dev/null && { sudo -n true 2>/dev/null || [ -t 0 ]; }; then
        sudo=sudo
    else
        fail "These Debian packages are missing, and installing them needs root. Ask an administrator to run:

    apt-get update && $line

then run the same make command again."
    fi
    $sudo apt-get update
    $sudo env DEBIAN_FRONTEND=noninteractive $line
}

# torch_build: "cpu" or "cuda", by torch_given or else by the machine's card and what the index, or WHEELS, offers.
torch_build() {
    wished=$(torch_wished) || exit 1
    [ "$wished" = cpu ] || { echo cuda && return; }
    version=$(sed -n 's/^torch==\(.*+cpu\) --hash.*/\1/p' docker/constraints.txt)
    if has_torch "$version"; then
        echo cpu
    elif [ -n "$(torch_given)" ]; then
        fail "TORCH=cpu, but ${WHEELS:-the package index} has no torch $version: name one that has in PIP_EXTRA_INDEX_URL, or set TORCH=cuda"
    else
        echo cuda
    fi
}

# has_torch VERSION: whether it can be had, or is there.
has_torch() {
    if [ -n "${WHEELS:-}" ]; then
        [ -e "$(echo "$WHEELS/torch-$1"-*)" ]
    else
        [ -d ".venv/lib/python3.11/site-packages/torch-$1.dist-info" ] ||
            .venv/bin/python -m pip index versions torch 2>/dev/null | grep -qF "$1"
    fi
}

# torch_given: what TORCH says, or said at an earlier set-up. A folder of wheels has a build of its own.
torch_given() {
    if [ -n "${TORCH+given}${WHEELS:-}" ]; then echo "${TORCH:-}"; else cat .setup/torch 2>/dev/null || true; fi
}

torch_wished() {
    given=$(torch_given)
    case "$given" in
    cpu | cuda) echo "$given" ;;
    "") if [ -z "${WHEELS:-}" ] && [ -e "$SYSTEM_ROOT/proc/driver/nvidia/version" ]; then echo cuda; else echo cpu; fi ;;
    *) fail "TORCH=$given, allowed: cpu, cuda, or empty to choose by the machine's card" ;;
    esac
}

# to_fetch BUILD: what installing costs with that build of torch.
to_fetch() {
    sed -n "s/.*\[MB\]:.*$1 \([0-9]*\).*/\1/p" docker/constraints.txt |
        awk -v build="$1" '{ printf "%.1f GB of Python packages (torch: %s), %s GB on disk, about %.0f minutes at 100 Mbit/s",
            $1 / 1000, build, build == "cpu" ? "2.2" : "6.0", $1 * 8 / 100 / 60 + 3 }'
}

# What the first set-up costs, before anything is fetched.
announce() {
    [ ! -x .venv/bin/python ] || return 0
    wished=$(torch_wished)
    say "To fetch: 0.2 GB of Debian packages, 0.8 GB on disk, less what is installed; $(to_fetch "$wished")"
    [ "$wished" = cuda ] || echo "If the package index has no CPU build of torch: $(to_fetch cuda). TORCH=cpu refuses that."
}

# locked FILE...: lines of docker/constraints.txt that these requirements files need, with the chosen build of torch.
locked() {
    build=$(torch_build) || exit 1
    awk -v files="$*" -v build="$build" 'BEGIN { for (n = split(files, f); n; n--) wanted[f[n]] }
        /^#/ { next }
        { take = 0; for (i = NF; $i != "#"; i--) { if ($i in wanted) take = 1; if ($i ~ /^(cpu|cuda)$/ && $i != build) next } }
        take' docker/constraints.txt
}

# moved: whether the environment's programs begin with the Python of another folder, from which this one was copied.
moved() {
    [ -f .venv/bin/pip ] && [ ! -L .venv ] && ! grep -qF -e "!$PWD/.venv/bin/" -e " $PWD/.venv/bin/" .venv/bin/pip
}

# put_back: where no new environment came about, as without network, the old one goes on serving.
put_back() {
    rm -f "${pins:-}"
    [ -e .venv.old ] || return 0
    rm -rf .venv
    mv .venv.old .venv
}

# wheels: where they come from without a network: a folder that `fetch` filled.
wheels() {
    [ -n "${WHEELS:-}" ] || return 0
    plain_path "$WHEELS" "WHEELS"
    [ -d "$WHEELS" ] || fail "WHEELS is '$WHEELS', allowed: a folder that \`docker/setup.sh fetch FOLDER\` filled on a machine with a network"
    printf '%s' "--no-index --find-links $WHEELS"
}

# fetch FOLDER: the Python packages of requirements.txt, for a machine without a network.
fetch() {
    case "${1:-}" in /*) ;; *) fail "The folder to fetch to must be an absolute path: docker/setup.sh fetch /media/stick/wheels" ;; esac
    [ -x .venv/bin/python ] || fail "Run \`make setup\` first: its pip fetches"
    pins=$(mktemp)
    trap 'rm -f "$pins"' EXIT
    locked requirements.txt >"$pins"
    .venv/bin/python -m pip download --no-deps --require-hashes --dest "$1" -r "$pins"
}

python_packages() {
    put_back # of a run that was killed
    trap put_back EXIT
    trap 'exit 130' INT TERM
    if moved || ! .venv/bin/python -m pip --version >/dev/null 2>&1; then
        say "Python environment in .venv"
        if [ -e .venv ] || [ -L .venv ]; then mv .venv .venv.old; fi
        "$PYTHON" -m venv --system-site-packages .venv
    fi
    pins=$(mktemp)
    locked "$1" $(sed -n 's/^-r //p' "$1") >"$pins"
    [ -s "$pins" ] || fail "docker/constraints.txt has no package of $1: .venv/bin/python docker/lock.py write"
    say "Python packages of $1: $(grep -c . "$pins")"
    from=$(wheels) || exit 1
    .venv/bin/python -m pip install --progress-bar on --no-deps --require-hashes $from -r "$pins" ||
        fail "The Python packages above could not be had. Without a network: docs/how-to/install.md#without-a-network"
    if [ -n "${TORCH+given}" ]; then mkdir -p .setup && printf '%s\n' "$TORCH" >.setup/torch; fi
    [ ! -e .venv.old ] || mv .venv.old .venv.gone # first, as removing it may be interrupted
    rm -rf .venv.gone
}

# Public readers of recordings in JavaScript, for the tests that compare with them: into .setup/node, by their lock.
javascript_packages() {
    if ! command -v npm >/dev/null; then
        say "npm is missing, so the tests of recordings in JavaScript's reader are skipped. For them install nodejs and npm, then: docker/setup.sh javascript"
        return
    fi
    mkdir -p .setup/node
    cp docker/javascript/package.json docker/javascript/package-lock.json .setup/node
    npm ci --prefix .setup/node --ignore-scripts --no-audit --no-fund
}

# Packages of ours that stand in for other people's messages: what is found elsewhere is neither built nor found here.
STAND_INS="audio_common_msgs control_msgs crtk_msgs kortex_driver openrst_control speech_recognition_msgs"

# UNDERLAY: devel or install spaces of other catkin workspaces, separated by colons, to build upon; remembered.
underlay() {
    [ -n "${UNDERLAY+given}" ] || UNDERLAY=$(cat .setup/underlay 2>/dev/null || true)
    printf '%s' "$UNDERLAY"
}

# Prints, separated by semicolons, the stand-ins that Debian or the underlay already have.
found_elsewhere() {
    found=
    for package in $STAND_INS; do
        for root in $(underlay | tr ':' ' ') /usr; do
            [ ! -e "$root/share/$package/cmake/${package}Config.cmake" ] || found="$found;$package"
        done
    done
    printf '%s\n' "${found#;}" | tr ';' '\n' | awk '!seen[$0]++' | paste -s -d ';'
}

# What catkin_make needs to know: the underlay, the stand-ins to build, whether the last build can be gone on with.
prepare() {
    say "catkin workspace"
    mkdir -p .setup
    under=$(underlay)
    for root in $(printf '%s' "$under" | tr ':' ' '); do
        case "$root" in /*) ;; *) fail "UNDERLAY names $root, allowed: absolute paths" ;; esac
        [ -e "$root/.catkin" ] || fail "UNDERLAY names $root, which is no devel or install space of catkin: it has no .catkin"
    done
    elsewhere=$(found_elsewhere)
    [ -z "$elsewhere" ] || say "not built, since they are found elsewhere: $elsewhere"
    for package in $STAND_INS; do
        rm -f "catkin_ws/src/$package/CATKIN_IGNORE"
        case ";$elsewhere;" in *";$package;"*) touch "catkin_ws/src/$package/CATKIN_IGNORE" ;; esac
    done
    cache=catkin_ws/build/CMakeCache.txt
    upon="$under|$elsewhere"
    if [ -f "$cache" ] && ! { grep -qx "CMAKE_HOME_DIRECTORY:INTERNAL=$PWD/catkin_ws/src" "$cache" &&
        [ "$(cat .setup/upon 2>/dev/null || echo '|')" = "$upon" ]; }; then
        rm -rf catkin_ws/build catkin_ws/devel # the checkout has moved, or is built upon something else
    fi
    printf '%s\n' "$under" >.setup/underlay
    printf '%s\n' "$upon" >.setup/upon
}

# catkin_make on the workspace, with further arguments for it.
build() {
    # Debian's ROS lives under /usr: only the underlay may be chained in, and cmake must find Debian's tools first
    python=$(cd .venv/bin && pwd -P)/python # whose folder comes first on PATH of who sources the space
    # Lisp's messages are left out: they take a sixth of the build, and nothing of ours is written in it
    (cd catkin_ws && env -u ROS_PACKAGE_PATH ROS_LANG_DISABLE="${ROS_LANG_DISABLE-genlisp}" CMAKE_PREFIX_PATH="$under" PATH="/usr/bin:/bin:$PATH" \
        catkin_make -DPYTHON_EXECUTABLE="$python" -DCATKIN_ENABLE_TESTING=ON "$@")
}

# compile_kinematics SPACE: with the packages of a devel or install space.
compile_kinematics() (
    say "Compiling the kinematics (once)"
    set +u # of catkin's script
    . "$1/setup.sh"
    set -u
    .venv/bin/python -c 'from rst_control.config import load_motion_config
from rst_control.assembly import make_trocar_context
from rst_control.kinematics.robot_model import load_robot
make_trocar_context(load_motion_config(), load_robot())'
)

# keep_compiled PREFIX: what is compiled beside the sources counts there too, by the digest of the sources.
keep_compiled() {
    (cd catkin_ws/src/rst_control/src/rst_control && find . \( -name '*.nb[ic]' -o -name kernels.stamp \) -print0 | tar -c --null -T -) |
        tar -x -C "$1/lib/python3/dist-packages/rst_control"
}

workspace() {
    prepare
    build
    compile_kinematics catkin_ws/devel
}

# install_space PREFIX: all packages with their files, runnable without the source; Python packages stay in .venv.
install_space() {
    case "${1:-}" in /*) ;; *) fail "The folder to install to must be an absolute path: PREFIX=/opt/voice_assist" ;; esac
    plain_path "$1" "PREFIX"
    mkdir -p "$1" 2>/dev/null && [ -w "$1" ] || fail "PREFIX is '$1', allowed: a folder that can be made and written"
    prepare
    build install -DCMAKE_INSTALL_PREFIX="$1"
    keep_compiled "$1"
    compile_kinematics "$1"
}

# What an image does not need: package lists, tests and data of others, symbols for debugging.
trim() {
    apt-get clean
    rm -rf /var/lib/apt/lists/* /usr/share/locale /usr/share/man
    packages=.venv/lib/python3.11/site-packages
    rm -rf "$packages/pybullet_data" "$packages/torch/test" "$packages/torch/include"
    find "$packages/torch/bin" -type f ! -name torch_shm_manager -delete
    for package in matplotlib networkx numba numpy scipy sympy; do
        find "$packages/$package" -type d -name tests -prune -exec rm -rf {} +
    done
    strip --strip-debug "$packages"/pybullet.*.so # four fifths of it
}

machine
case "${1:-}" in
check) ;;
trim) trim ;;
system) system_packages "${2:-docker/apt-packages.txt}" ;;
python) python_packages "${2:-requirements.txt}" ;;
fetch) fetch "${2:-}" ;;
javascript) javascript_packages ;;
workspace) workspace ;;
install) install_space "${2:-}" ;;
elsewhere) found_elsewhere ;;
*) fail "usage: docker/setup.sh check | trim | system [FILE] | python [FILE] | fetch FOLDER | javascript | workspace | install PREFIX | elsewhere" ;;
esac
