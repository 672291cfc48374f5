# SPDX-License-Identifier: BSD-3-Clause
"""Every Python package that set-up installs, with version and digest, in docker/constraints.txt.

`.venv/bin/python docker/lock.py write` resolves what requirements*.txt name, at the versions that
are installed, with which the tests passed. `check` needs no network: `make lint` runs it.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import sysconfig
import tempfile
import urllib.request
from importlib.metadata import distributions
from pathlib import Path
from typing import Any, Final

ROOT: Final = Path(__file__).resolve().parents[1]
LOCK: Final = ROOT / "docker" / "constraints.txt"
# Of requirements*.txt, least first
FILES: Final = ("", "-dev", "-parquet", "-foxglove", "-bench", "-train", "-languages")
BUILDS: Final = ("cpu", "cuda")  # of torch
PIN: Final = re.compile(r"([\w.-]+)(={2,3})(\S+)((?: --hash=sha256:[0-9a-f]{64})+)  # (.+)")
HEADER: Final = """\
# All Python packages with their digests, of requirements*.txt and what those need in turn.
# Made by `.venv/bin/python docker/lock.py write`; docker/setup.sh installs by it.
# After `#`: the files that need a package, and `cpu` or `cuda` if only that build of torch does.
# To fetch for requirements.txt [MB]: {sizes}
"""


def requirements(name: str) -> dict[str, str]:
    """Pins of a file, `requirements` + name: version by package, "-r" left out."""
    lines = (ROOT / f"requirements{name}.txt").read_text(encoding="utf-8").splitlines()
    return {found[1]: found[2] for line in lines if (found := re.match(r"([\w.-]+)==(\S+)", line))}


def key(name: str) -> str:
    """Name of a package as indexes compare it."""
    return re.sub(r"[-_.]+", "-", name).lower()


def resolve(pip: list[str], name: str, build: str, versions: Path) -> list[dict[str, Any]]:
    """What a file needs, as pip reports it; nothing is installed."""
    lines = (ROOT / f"requirements{name}.txt").read_text(encoding="utf-8").splitlines()
    pins = requirements(name)
    alone = {line.split("==")[0] for line in lines if re.match(r"[^#]*#.*--no-deps", line)}
    alone = pins.keys() if name in ("-train", "-languages") else alone & pins.keys()
    torch = {"cpu": f"=={pins.get('torch')}+cpu", "cuda": f"==={pins.get('torch')}"}
    wanted = {n: torch[build] if n == "torch" else f"=={v}" for n, v in pins.items()}
    found: list[dict[str, Any]] = []
    for only, more in ((pins.keys() - alone, ["-c", str(versions)]), (alone, ["--no-deps"])):
        if only:
            line = [*pip, "install", "--dry-run", "--ignore-installed", "--quiet", "--report", "-"]
            line += [*more, *(n + wanted[n] for n in sorted(only))]
            found += json.loads(subprocess.run(line, check=True, stdout=subprocess.PIPE).stdout)[
                "install"
            ]
    return found


def write() -> None:
    """Resolve all files and write the lock."""
    digests: dict[str, str] = {}
    files: dict[str, set[str]] = {}
    sizes = dict.fromkeys(BUILDS, 0)
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([sys.executable, "-m", "venv", folder], check=True)
        pip = [f"{folder}/bin/python", "-m", "pip"]
        subprocess.run([*pip, "install", "--quiet", "--upgrade", "pip"], check=True)
        versions = Path(folder) / "versions.txt"
        versions.write_text(tested(), encoding="utf-8")
        for name in FILES:
            found = {
                b: resolve(pip, name, b, versions) for b in (BUILDS if not name else BUILDS[:1])
            }
            of_builds = {build: {pin(one, build) for one in some} for build, some in found.items()}
            for build, some in found.items():
                for one in some:
                    line = pin(one, build)
                    digests[line] = one["download_info"]["archive_info"]["hashes"]["sha256"]
                    files.setdefault(line, set()).add(f"requirements{name}.txt")
                    if not all(line in pins for pins in of_builds.values()):
                        files[line].add(build)
                    sizes[build] += 0 if name else size(one["download_info"]["url"])
    order = sorted(digests, key=lambda line: (key(line.split("=")[0]), line))
    lines = [f"{p} --hash=sha256:{digests[p]}  # {' '.join(sorted(files[p]))}\n" for p in order]
    shown = ", ".join(f"{build} {sizes[build] / 1e6:.0f}" for build in BUILDS)
    LOCK.write_text(HEADER.format(sizes=shown) + "".join(lines), encoding="utf-8")


def tested() -> str:
    """Versions that are installed, as pip's constraints. Torch has two builds, and is left out."""
    versions: dict[str, str] = {}
    for one in distributions():  # the first of a name is the one that is imported
        versions.setdefault(key(one.name), one.version)
    return "".join(f"{n}=={v}\n" for n, v in versions.items() if n != "torch")


def pin(one: dict[str, Any], build: str) -> str:
    """Name and version of what pip reports."""
    name, found = one["metadata"]["name"], one["metadata"]["version"]
    # "===": 2.13.0 alone, where "==" takes 2.13.0+cpu too
    return f"{name}{'===' if name == 'torch' and build == 'cuda' else '=='}{found}"


def size(url: str) -> int:
    """Bytes of a file, without fetching it."""
    if url.startswith("file:"):
        return Path(urllib.request.url2pathname(url.removeprefix("file://"))).stat().st_size
    with urllib.request.urlopen(urllib.request.Request(url, method="HEAD")) as answer:
        return int(answer.headers["Content-Length"])


def check() -> list[str]:
    """What is wrong with the lock: its lines, pins of the files, packages that are installed."""
    wrong = []
    locked: dict[str, dict[str, list[str]]] = {}
    for line in LOCK.read_text(encoding="utf-8").splitlines():
        if found := PIN.fullmatch(line):
            locked.setdefault(key(found[1]), {})[found[3]] = found[5].split()
        elif not line.startswith("#"):
            wrong.append(f"no pin with a digest: {line}")
    for name in FILES:
        file = f"requirements{name}.txt"
        for package, pinned in requirements(name).items():
            versions = locked.get(key(package), {})
            of = {v.partition("+")[0] for v, files in versions.items() if file in files}
            if of != {pinned}:
                wrong.append(f"{file} pins {package}=={pinned}, locked: {sorted(of)}")
    for one in distributions(path=[sysconfig.get_path("purelib")]):  # not what setuptools carries
        versions = locked.get(key(one.name), {})
        if versions and one.version not in versions:
            wrong.append(f"{one.name} {one.version} is installed, locked: {sorted(versions)}")
    return wrong


if __name__ == "__main__":
    if sys.argv[1:] == ["write"]:
        write()
    elif sys.argv[1:] != ["check"]:
        sys.exit("usage: docker/lock.py write | check")
    if faults := check():
        remedy = "make it again: .venv/bin/python docker/lock.py write"
        sys.exit("\n  ".join(["docker/constraints.txt:", *faults, remedy]))
