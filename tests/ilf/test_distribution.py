"""Names of the installed packages, the package's page, credits, citation. `.ci/wheel` tests the wheel itself."""

import ast
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from xml.etree import ElementTree

import pytest

import ilf

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
README = (ROOT / "README.md").read_text(encoding="utf-8")
NOTICE = (ROOT / "assets" / "NOTICE").read_text(encoding="utf-8")
EXTRAS = PROJECT["project"]["optional-dependencies"]
FOR_DEVELOPERS = {"test", "dev"}

EDITABLE = os.pathsep.join(
    str((ROOT / folder).resolve()) for folder in PROJECT["tool"]["hatch"]["build"]["dev-mode-dirs"]
)
"""The search path of an editable install."""


def _python(*arguments: str, path: str = EDITABLE) -> subprocess.CompletedProcess[str]:
    # -P: not from the current folder
    return subprocess.run(
        [sys.executable, "-P", *arguments], capture_output=True, text=True, env=os.environ | {"PYTHONPATH": path}
    )


def test_the_windows_modules_name_neither_their_folder_nor_their_package():
    names = re.compile(r"(gui|ilf_studio)(\.\w+)*")
    for path in (ROOT / "gui").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                found = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom):
                found = [node.module or ""] if node.level == 0 else []
            else:
                found = [node.value] if isinstance(node, ast.Constant) and isinstance(node.value, str) else []
            assert not [name for name in found if names.fullmatch(name)], f"{path}:{getattr(node, 'lineno', 0)}"


def test_an_editable_install_imports_the_window_by_its_installed_name():
    module = PROJECT["project"]["gui-scripts"]["ilf-gui"].partition(":")[0]
    found = _python("-c", f"import {module} as start; print(start.__name__, start.__file__, start.main.__module__)")
    assert found.stdout.split() == [module, str(ROOT / "gui" / "app" / "start.py"), module], found.stderr
    told = _python("-m", module.partition(".")[0], "--version")
    assert (told.returncode, told.stdout, told.stderr) == (0, f"ilf-gui {ilf.__version__}\n", "")


def test_entry_points_are_functions_in_the_clone():
    packages = PROJECT["tool"]["hatch"]["build"]["targets"]["wheel"]
    installed = {packages["sources"].get(name, name): name for name in packages["packages"]}
    assert sorted(installed) == PROJECT["tool"]["check-wheel-contents"]["toplevel"]
    for entry in (PROJECT["project"]["scripts"] | PROJECT["project"]["gui-scripts"]).values():
        module, _, function = entry.partition(":")
        package, _, rest = module.partition(".")
        file = ROOT / installed[package] / rest.replace(".", "/")
        source = (file / "__init__.py" if file.is_dir() else file.with_suffix(".py")).read_text(encoding="utf-8")
        assert function in {node.name for node in ast.parse(source).body if isinstance(node, ast.FunctionDef)}


def test_the_wheel_has_every_network_and_no_file_twice():
    wheel = PROJECT["tool"]["hatch"]["build"]["targets"]["wheel"]
    networks = (ROOT / "assets" / "models" / "SHA256SUMS").read_text(encoding="utf-8").split()[1::2]
    assert {f"assets/models/{name}" for name in networks} <= wheel["force-include"].keys()
    assert not wheel["force-include"].keys() & wheel["shared-data"].keys()


def test_workflows_pin_every_action_and_the_package_names_the_versions_that_they_test():
    workflows = [path.read_text(encoding="utf-8") for path in (ROOT / ".github" / "workflows").glob("*.yml")]
    actions = [action for text in workflows for action in re.findall(r"uses: (\S+)", text)]
    assert actions
    assert [action for action in actions if not re.fullmatch(r"[\w./-]+@[0-9a-f]{40}", action)] == []
    tested = {version for text in workflows for version in re.findall(r'"(3\.\d+)"', text)}
    classified = {line.rpartition(" ")[2] for line in PROJECT["project"]["classifiers"] if ":: Python :: 3." in line}
    assert tested == classified


def test_the_desktop_knows_the_commands_and_project_files():
    share = ROOT / "assets" / "packaging" / "share"
    entry = dict(re.findall(r"^(\w+)=(.*)$", (share / "applications" / "ilf-studio.desktop").read_text(), re.MULTILINE))
    kind = ElementTree.parse(share / "mime" / "packages" / "ilf-studio.xml").find("{*}mime-type")
    page = ElementTree.parse(share / "metainfo" / "ilf-studio.metainfo.xml")
    assert kind is not None
    assert (kind.find("{*}glob").get("pattern"), f"{kind.get('type')};") == ("*.ilf", entry["MimeType"])
    assert page.findtext("provides/mediatype") == kind.get("type")
    assert entry["Exec"].split()[0] in PROJECT["project"]["gui-scripts"]
    assert (page.findtext("name"), page.findtext("summary")) == (entry["Name"], entry["Comment"])
    assert page.findtext("launchable") == "ilf-studio.desktop"


def test_the_packages_page_has_no_link_that_only_a_clone_can_follow():
    hook = PROJECT["tool"]["hatch"]["metadata"]["hooks"]["fancy-pypi-readme"]
    (fragment,) = hook["fragments"]
    assert fragment["path"] == "README.md"
    page = README.partition(fragment["end-before"])[0]
    for substitution in hook["substitutions"]:
        page = re.sub(substitution["pattern"], substitution["replacement"], page)
    assert [link for link in re.findall(r"\]\(([^)]*)\)", page) if not link.startswith(("https:", "#"))] == []
    assert "Windows, servers, extras and supported platforms: installation." in page
    assert "[doi:10.3390/app14020696](https://doi.org/10.3390/app14020696)" in page


def test_every_package_that_a_user_needs_is_in_the_notice():
    needed = list(PROJECT["project"]["dependencies"])
    for extra in EXTRAS.keys() - FOR_DEVELOPERS:
        needed += EXTRAS[extra]
    names = {re.match(r"[\w.-]+", line)[0] for line in needed} - {"ilf-studio"}
    entries = re.findall(r"^- ([^:\n]+): ", NOTICE, re.MULTILINE)
    listed = {name for entry in entries for name in re.split(", (?!with )", entry.partition(", with")[0])}
    assert listed == names


def test_the_base_install_can_import_every_public_name_and_every_command():
    program = """
import sys
from importlib import import_module
from importlib.metadata import packages_distributions, requires
from pkgutil import iter_modules
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name as canonical

needed, found = [Requirement(line) for line in sys.argv[1:]], set()
while needed:
    requirement = needed.pop()
    name = canonical(requirement.name)
    if name not in found and (requirement.marker is None or requirement.marker.evaluate({"extra": ""})):
        found.add(name)
        needed += map(Requirement, requires(name) or [])
for module, names in packages_distributions().items():
    if not {*map(canonical, names)} & {*found, "ilf-studio"}:
        sys.modules[module] = None
import ilf, ilf.cli
for name in dir(ilf):
    getattr(ilf, name)
for module in iter_modules(ilf.cli.__path__, "ilf.cli."):
    import_module(module.name)
"""
    run = _python("-c", program, *PROJECT["project"]["dependencies"])
    assert (run.returncode, run.stderr) == (0, "")


def test_the_notice_credits_all_frames_of_the_training():
    card = (ROOT / "assets" / "models" / "README.md").read_text(encoding="utf-8")
    rows = card.partition("| frames | from | licence |")[2].partition("\n\n")[0].splitlines()[2:]
    credit = " ".join(NOTICE.partition("2. Packages")[0].split())
    assert len(rows) == 6
    for row in rows:
        _, origins, licence = (cell.strip() for cell in row.strip("|").split("|"))
        assert all(origin in credit for origin in re.findall(r"`([^`]+)`", origins))
        assert licence in credit


@pytest.mark.parametrize("name", PROJECT["project"]["license-files"])
def test_files_with_terms_are_there(name):
    assert (ROOT / name).stat().st_size > 500


def test_the_citation_is_that_of_the_readme():
    citation = (ROOT / ".github" / "CITATION.cff").read_text(encoding="utf-8")
    fields = dict(re.findall(r"(\w+) = \{([^}]+)\}", README))
    assert f'title: "{fields["title"]}"' in citation
    assert f"doi: {fields['doi']}\n" in citation
    people = zip(*(re.findall(rf"{part}: (.+)", citation) for part in ("family-names", "given-names")), strict=True)
    assert " and ".join(f"{family}, {given}" for family, given in people) == fields["author"]
    assert PROJECT["project"]["urls"]["Paper"] == f"https://doi.org/{fields['doi']}"


def test_documents_name_extras_that_there_are_and_users_install_by_name():
    documents = [ROOT / "README.md", *(ROOT / "assets").rglob("*.md"), *(ROOT / ".github").rglob("*.md")]
    for document in documents:
        if "decisions" in document.parts:
            continue
        text = document.read_text(encoding="utf-8")
        for form, extras in re.findall(r"(ilf-studio|['\"]\.)\[([\w,]+)\]", text):
            assert set(extras.split(",")) <= EXTRAS.keys(), document
            if document.parent == ROOT / "assets" / "docs" and document.name not in ("install.md", "reliability.md"):
                assert form == "ilf-studio", f"{document} is for users, who have no clone"
