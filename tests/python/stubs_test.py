"""The type stubs say what the extension modules have."""
import ast
import importlib
import pathlib
import re

import livermark
import pytest

FOLDER = pathlib.Path(livermark.__file__).resolve().parent
MODULES = [path.stem for path in FOLDER.glob("_*.pyi")]


def arguments_in_docstring(function):
    """Names of the arguments, and those with a default, of the first line of a docstring of pybind11."""
    inside = re.match(r"\w+\((.*)\) -> ", function.__doc__.splitlines()[0]).group(1)
    words = re.split(r", (?=\w+: )", inside) if inside else []
    names = [re.match(r"\w+", word).group() for word in words]
    return [name for name in names if name != "self"], [name for name, word in zip(names, words) if " = " in word]


def arguments_in_stub(function):
    names = [argument.arg for argument in function.args.args]
    with_default = names[len(names) - len(function.args.defaults):]
    only_by_name = [argument.arg for argument in function.args.kwonlyargs]  # all have a default
    return [name for name in names if name != "self"] + only_by_name, with_default + only_by_name


def public(names):
    return {name for name in names if not name.startswith("_")}


def check_function(stub, function):
    assert arguments_in_docstring(function) == arguments_in_stub(stub), function.__doc__


def check_class(stub, kind):
    members = {node.name: node for node in stub.body if isinstance(node, ast.FunctionDef)}
    attributes = {node.target.id for node in stub.body if isinstance(node, ast.AnnAssign)}
    assert public(vars(kind)) == public(members) | attributes
    for name, node in members.items():
        if not node.decorator_list and (name != "__init__" or "__init__" in vars(kind)):
            check_function(node, getattr(kind, name))
        elif node.decorator_list:
            assert vars(kind)[name].fset is None, name
    for name in attributes:
        assert vars(kind)[name].fset is not None, name


@pytest.mark.parametrize("module", MODULES)
def test_stubs_have_the_names_and_arguments_of_the_module(module):
    stubs = {node.name: node for node in ast.parse((FOLDER / f"{module}.pyi").read_text()).body if hasattr(node, "name")}
    compiled = importlib.import_module("livermark." + module)
    assert public(vars(compiled)) == set(stubs)
    for name, stub in stubs.items():
        (check_class if isinstance(stub, ast.ClassDef) else check_function)(stub, getattr(compiled, name))


@pytest.mark.parametrize("module", MODULES)
def test_every_function_of_the_module_has_a_docstring(module):
    compiled = importlib.import_module("livermark." + module)
    for name in public(vars(compiled)):
        words = getattr(compiled, name).__doc__
        assert len(words.strip().splitlines()[-1].split()) >= 4, name  # behind the signature


def test_the_package_has_all_of_its_modules():
    for module in MODULES:
        for name in public(vars(importlib.import_module("livermark." + module))):
            assert hasattr(livermark, name) and name in livermark.__all__, name


def test_the_package_exports_what_it_says():
    assert len(set(livermark.__all__)) == len(livermark.__all__)
    for name in livermark.__all__:
        assert getattr(livermark, name).__doc__, name
