"""The rooms of the bridge: what each may import. bridge/README.md draws them."""

import ast
import graphlib
import importlib.util
import re
import sys
from pathlib import Path

import pytest

import qstereo_bridge

FOLDER = Path(qstereo_bridge.__file__).parent
# Each room with those below it, which it may import from.
BELOW = {
    "core": [],
    "verify": ["core"],
    "samplers": ["core"],
    "ocean": ["core", "samplers"],
    "runs": ["core", "samplers", "ocean"],
    "desk": ["core", "verify", "samplers", "ocean", "runs"],
}
# google_crc32c is small and has no dependencies. dwave.optimization is for to_nl() alone; that the
# rest works without it is in test_api.py.
CORE_NEEDS = {"numpy", "dimod", "google_crc32c", "dwave"}


def name_of(path, folder):
    """The dotted name of a module in `folder`, a package's own that of its folder."""
    return ".".join(path.relative_to(folder).with_suffix("").parts).removesuffix(".__init__")


def imports_of(path, folder, modules):
    """(The package's own modules that a module imports, other packages), wherever in it the import
    stands, in a function or for types too."""
    tree, own, others = ast.parse(path.read_text()), set(), set()
    package = name_of(path.parent / "__init__.py", folder)
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            others.update(alias.name.split(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level:
            others.add(node.module.split(".")[0])
        elif isinstance(node, ast.ImportFrom):
            place = importlib.util.resolve_name("." * node.level + (node.module or ""),
                                                f"p.{package}".rstrip(".")).removeprefix("p")[1:]
            own.update(f"{place}.{alias.name}" if f"{place}.{alias.name}" in modules else
                       place or alias.name for alias in node.names)
    return own & modules, others


def faults(folder):
    """What is wrong with the imports of a package with these rooms: list of sentences."""
    paths = {name_of(path, folder): path for path in folder.rglob("*.py") if path.parent != folder}
    found, graph = [], {}
    for name, path in paths.items():
        room = name.split(".")[0]
        graph[name], others = imports_of(path, folder, set(paths))
        found += [f"{name} imports {other}, which is not below it" for other in graph[name]
                  if other.split(".")[0] not in [room, *BELOW[room]]]
        found += [f"{name} imports {other}" for other in others
                  if room == "core" and other not in CORE_NEEDS | sys.stdlib_module_names]
    try:
        graphlib.TopologicalSorter(graph).prepare()
    except graphlib.CycleError as error:
        found.append(f"a circle: {' '.join(error.args[1])}")
    return found


def test_each_room_sees_those_below_it():
    assert {path.parent.name for path in FOLDER.glob("*/__init__.py")} == BELOW.keys()
    assert faults(FOLDER) == []


@pytest.mark.parametrize("place, line, fault", [
    ("core/models.py", "from ..samplers import solvers", "samplers.solvers, which is not below"),
    ("core/models.py", "def f():\n    from ..verify import verify", "verify, which is not below"),
    ("samplers/solvers.py", "from ..ocean.qpu import Qpu", "ocean.qpu, which is not below"),
    ("core/models.py", "import scipy", "core.models imports scipy"),
    ("core/failure.py", "from .models import ones", "a circle: core"),
])
def test_a_wrong_import_is_found(place, line, fault, tmp_path):
    """Of a copy in which one module has one import more."""
    for path in FOLDER.rglob("*.py"):
        copy = tmp_path / path.relative_to(FOLDER)
        copy.parent.mkdir(exist_ok=True)
        copy.write_text(path.read_text())
    with open(tmp_path / place, "a") as stream:
        stream.write(f"\n{line}\n")
    assert any(fault in one for one in faults(tmp_path))


def test_readme_names_every_module():
    """The map of the rooms has them all, and no other."""
    readme = (FOLDER.parent / "README.md").read_text()
    listed = {f"{room}.{name}" for room, names in re.findall(
        r"^\| `(\w+)` \|[^|]*\| (.*?) \|$", readme, re.M) for name in re.findall(r"`(\w+)`", names)}
    assert listed == {name_of(path, FOLDER) for path in FOLDER.glob("*/*.py")
                      if path.name != "__init__.py"}
