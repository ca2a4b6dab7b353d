"""How the project is built: arrows of import, packages, the grammar of kernels."""

import ast
import importlib.machinery
import importlib.util
import re
import sys
import tomllib
from pathlib import Path

import pytest

import warp_origami

ROOT = Path(__file__).parents[1]
TREES = {"warp_origami": ROOT / "warp_origami", "warp_origami.kernels": ROOT / "kernels"}
TREES["warp_origami.scenes"] = ROOT / "scenes"

# Who may import whom, inside the project. What is not listed may import nothing of it.
ARROWS = {
    "errors": set(),
    "clock": set(),
    "machine": set(),
    "scenes": set(),
    "kernels": {"kernels"},
    "model": {"model", "errors"},
    "scene": {"scene", "scenes", "model", "errors"},
    "terms": {"terms", "kernels", "model", "errors"},
    "compose": {"terms", "scene", "model", "errors"},
    "system": {"compose", "terms", "scene", "model", "errors", "clock"},
    "description": {"system", "scene", "model", "clock"},
    "solve": {"solve", "system", "terms", "scene", "model", "errors", "clock"},
    # files and progress observe a run: they know its records and nothing else of solve
    "output": {"output", "solve.records", "scene", "model", "errors", "clock", "machine"},
    "api": {"output", "solve", "scene", "model", "errors"},
    "study": {
        *("study", "api", "solve", "scene", "scenes", "output", "terms.threads", "model", "errors", "clock", "machine"),
    },
    "cli": {"cli", "study", "output", "solve", "description", "scene", "scenes", "errors", "clock"},
    "__init__": {"api", "scene", "errors"},
    "__main__": {"cli"},
}
FOREIGN = {
    "kernels": {"warp", "numpy"},
    "model": {"numpy", "scipy"},
    "scene": {"numpy", "pydantic", "pydantic_core", "tomli_w"},
    "errors": set(),
}


def sources():
    """Every module of the product: dotted name -> path."""
    found = {}
    for package, folder in TREES.items():
        for path in sorted(folder.rglob("*.py")):
            parts = [package, *path.relative_to(folder).with_suffix("").parts]
            found[".".join(parts)] = path
    return found


MODULES = sources()


def imports(name, path):
    """Dotted names that a module imports, relative imports resolved."""
    package = name.split(".")[:-1]
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else []
            module = ".".join([*base, *([node.module] if node.module else [])])
            # `from package import name` may import a module of that name
            yield from (f"{module}.{alias.name}" for alias in node.names)


def layer(dotted):
    """The part of the project that a dotted name below warp_origami belongs to."""
    parts = dotted.split(".")
    return parts[1] if len(parts) > 1 else "__init__"


@pytest.mark.parametrize("name", MODULES)
def test_arrows_of_import_run_down(name):
    allowed = ARROWS[layer(name)]
    for target in imports(name, MODULES[name]):
        if target.split(".")[0] != "warp_origami":
            continue
        inner = target.removeprefix("warp_origami.")
        assert any(inner == one or inner.startswith(one + ".") for one in allowed), f"{name} imports {target}"


@pytest.mark.parametrize("name", MODULES)
def test_foreign_packages_stay_where_they_belong(name):
    foreign = {target.split(".")[0] for target in imports(name, MODULES[name])} - {"warp_origami"}
    foreign = {package for package in foreign if package not in sys.stdlib_module_names}
    allowed = FOREIGN.get(layer(name))
    if allowed is not None:
        assert foreign <= allowed
    assert "pxr" not in foreign or name in {"warp_origami.output.usd", "warp_origami.output.animation_file"}


def test_modules_import_each_other_without_cycles():
    edges = {}
    for name, path in MODULES.items():
        targets = list(imports(name, path))
        edges[name] = {m for m in MODULES if any(t == m or t.startswith(m + ".") for t in targets)} - {name}
    done, active = set(), []

    def visit(module):
        assert module not in active, " -> ".join([*active[active.index(module) :], module])
        if module in done:
            return
        active.append(module)
        for target in edges[module]:
            visit(target)
        active.pop()
        done.add(module)

    for module in edges:
        visit(module)


def test_package_list_equals_the_tree():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["setuptools"]
    tree = {name.removesuffix(".__init__") for name in MODULES if name.endswith(".__init__")}
    assert sorted(project["packages"]) == sorted(tree)
    folders = {path.parent for path in MODULES.values()}
    assert {path.parent for path in MODULES.values() if path.name == "__init__.py"} == folders


def test_kernels_refuse_another_name():
    spec = importlib.util.spec_from_file_location("kernels", ROOT / "kernels" / "__init__.py")
    with pytest.raises(ImportError, match=r"warp_origami\.kernels"):
        spec.loader.exec_module(importlib.util.module_from_spec(spec))


def test_bundled_scenes_open_with_a_comment():
    for path in (ROOT / "scenes").rglob("*.toml"):
        assert path.read_text(encoding="utf-8").startswith("# "), path


def _kernels():
    for path in sorted((ROOT / "kernels").glob("*.py")):
        text = path.read_text(encoding="utf-8")
        for node in ast.parse(text).body:
            if isinstance(node, ast.FunctionDef) and any("kernel" in ast.unparse(d) for d in node.decorator_list):
                yield pytest.param(node, text.splitlines(), id=f"{path.stem}.{node.name}")


@pytest.mark.parametrize(("kernel", "lines"), list(_kernels()))
def test_grammar_of_kernels(kernel, lines):
    """Inputs, then `# out`, then what is written; no backward pass; a docstring of a line; few arguments."""
    decorators = [ast.unparse(decorator) for decorator in kernel.decorator_list]
    assert any("enable_backward=False" in decorator for decorator in decorators)
    docstring = ast.get_docstring(kernel)
    assert docstring
    assert len(docstring.split("\n\n")[0].splitlines()) <= 2
    assert len(kernel.args.args) <= 12

    head = range(kernel.lineno, kernel.body[0].lineno)
    marks = [number for number in head if lines[number - 1].strip() == "# out"]
    assert len(marks) == 1
    outputs = {argument.arg for argument in kernel.args.args if argument.lineno > marks[0]}
    inputs = {argument.arg for argument in kernel.args.args} - outputs
    assert outputs

    written = set(_written(kernel))
    assert not written & inputs
    if "array" in ast.unparse(kernel.args):
        assert written | _passed(kernel) >= outputs  # directly or by a function that is given the array


def _written(kernel):
    """Names that are assigned to, also as `name[i] = ...`, and arrays that atomics change."""
    for node in ast.walk(kernel):
        if isinstance(node, ast.Assign | ast.AugAssign):
            for target in node.targets if isinstance(node, ast.Assign) else [node.target]:
                for part in target.elts if isinstance(target, ast.Tuple) else [target]:
                    while isinstance(part, ast.Subscript | ast.Attribute):
                        part = part.value
                    yield part.id
        elif isinstance(node, ast.Call) and re.match(r"wp\.atomic_", ast.unparse(node.func)):
            yield ast.unparse(node.args[0])


def _passed(kernel):
    calls = [node for node in ast.walk(kernel) if isinstance(node, ast.Call)]
    return {argument.id for call in calls for argument in call.args if isinstance(argument, ast.Name)}


def test_kernels_hold_no_scalar_type_but_that_of_precision():
    for path in (ROOT / "kernels").glob("*.py"):
        if path.name != "precision.py":
            assert not re.search(r"wp\.(float\d+|vec\d\b|mat\d\d\b|f64|f32)", path.read_text(encoding="utf-8")), path


def test_product_does_not_name_folders_outside_the_checkout():
    outside = "../" + "shared"
    paths = [*MODULES.values(), *ROOT.glob("scenes/**/*.toml"), *ROOT.glob("tests/*.py"), *ROOT.glob("*.md")]
    for path in [*paths, ROOT / "pyproject.toml"]:
        assert outside not in path.read_text(encoding="utf-8"), path


def test_a_checkout_that_is_not_installed_finds_all_its_packages():
    """Python prefers the folder where it runs to an installation: there kernels/ and scenes/ are beside the package."""
    for name in ("kernels", "scenes"):
        found = importlib.machinery.PathFinder.find_spec(f"warp_origami.{name}", warp_origami.__path__)
        assert Path(found.origin).parent == ROOT / name
