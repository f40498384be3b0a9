"""Parsers of the command line with their help and errors, and the exit statuses. Quick to import."""

from __future__ import annotations

import argparse
import os
import re
import sys
from collections.abc import Callable, Collection, Iterable, Mapping
from inspect import cleandoc
from itertools import takewhile
from typing import Any, NoReturn

from .._runtime.files import is_address, split_dataset
from ..errors import IlfError, InputError, did_you_mean

DONE, FAILED, WRONG_USAGE, HUNG_UP, INTERRUPTED, TERMINATED = 0, 1, 2, 129, 130, 143

EXIT_STATUSES = {
    DONE: "done",
    FAILED: "failed: an input, an output or a frame of a batch; the reason is one line on stderr",
    WRONG_USAGE: "wrong usage: unknown or contradictory arguments",
    HUNG_UP: "ended because the terminal was closed (SIGHUP)",
    INTERRUPTED: "interrupted (Ctrl+C)",
    TERMINATED: "ended by a request to terminate (SIGTERM)",
}
"""Exit status -> its meaning."""


class UsageError(IlfError):
    """Unknown or contradictory arguments."""


_MEANINGS = {
    "depth-scale depth-factor depth-divisor depth-unit scale factor unit units png-scale": ("--depth-units",),
    "camera cam calib calibration camera-info camera-file k kmat fx": ("--intrinsics",),
    "depth-camera depth-calib depth-k": ("--depth-intrinsics",),
    "depth-format encoding format": ("--depth-encoding", "--format"),
    "gpu cuda cpu": ("--device", "The environment variable ILF_DEVICE selects the device."),
    "j jobs n workers processes procs parallel num-workers threads cores": (
        *("--jobs", "--threads"),
        "Blocks run on all cores; ilf batch completes several frames at a time: --jobs.",
    ),
    "verbose v debug vv log-level": ("--progress", "All notes and warnings are shown without an option."),
    "silent q no-progress": ("--quiet",),
    "o output output-dir outdir out-dir dest destination save": ("--out",),
    "f force overwrite": ("--force", "Files of the same names in --out are replaced without an option."),
    "gt truth": ("--ground-truth",),
    "mask": ("--invalid-mask",),
    "borders": ("--drawn",),
    "nodata no-data missing invalid-value ignore fill-value": ("--invalid",),
    "max-depth min-depth depth-max depth-min depth-trunc max-range": ("Mark depth to leave out by --invalid-mask.",),
    "labels segmentation seg masks": ("--blocks", "--from"),
    "key index frame-id frame-index": ("--frame",),
    "iterations iter max-iter maxiter n-iter niter": ("--max-iterations",),
    "config method": ("--preset",),
    "ply pcd point-cloud cloud-format": ("--cloud", "ilf complete writes a point cloud without an option."),
    "run fill inpaint process infer predict": ("complete",),
    "gui window view open display": ("The window is ilf-gui.",),
    "live play": ("`ilf-gui --live SOURCE` plays in the window, `ilf capture DIR` writes a frame of the camera.",),
    "eval score test": ("evaluate",),
    "segment extract": ("blocks",),
    "demo example": ("sample", "--sample"),
    "presets list-presets": ("--presets", "`ilf info --presets` lists the presets."),
    "convert export": ("export", "`ilf project export` writes results for other programs."),
}
"""Words of other programs -> what they mean here: the first that the parser knows; or else a sentence."""


def _suggested(word: str, known: Iterable[str]) -> str:
    """Suggest the known word that means the same or is most similar, as a question after a space; "" if there is none.

    Examples
    --------
    >>> _suggested("complet", ["complete", "blocks"])
    ' Did you mean complete?'
    >>> _suggested("--depth-scale", ["--depth-units", "--scales"])
    ' Did you mean --depth-units?'
    >>> _suggested("fly", ["complete", "blocks"])
    ''
    """
    known, plain = list(known), re.sub(r"^-+|\d+$", "", word).replace("_", "-").lower()  # -j4 is -j
    for meant in next((to for words, to in _MEANINGS.items() if plain in words.split()), ()):
        if meant in known:
            return f" Did you mean {meant}?"
        if " " in meant:
            return f" {meant}"
    return did_you_mean(word, known)


_FLAG = re.compile(r"--\S*|-[A-Za-z?]\S*")
_NEEDED = re.compile(r"with (--[\w-]+): ")
"""How the explanation of a flag begins that is given with another one only."""


class Parser(argparse.ArgumentParser):
    """A parser whose errors are one line that suggests the most similar word.

    Parameters
    ----------
    **how
        As for ArgumentParser. Flags cannot be abbreviated.
    """

    def __init__(self, **how: Any) -> None:
        super().__init__(**{"allow_abbrev": False, **how})

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse as ArgumentParser, but report an unknown flag as an error of its command; `given` of the result has the
        flags that are given, by the name of their value."""
        words = sys.argv[1:] if args is None else list(args)
        found = namespace or argparse.Namespace()
        found.given = dict[str, str]()
        for word in takewhile(lambda word: word != "--", words):
            if self._subparsers is not None and not word.startswith("-"):
                break  # the rest belongs to a sub-parser
            flag = word.partition("=")[0]
            if flag in self._option_string_actions:
                found.given[self._option_string_actions[flag].dest] = flag
            elif _FLAG.fullmatch(flag):
                self.error(f"There is no option {flag}.{_suggested(flag, self._option_string_actions)}")
        parsed = super().parse_known_args(words, found)
        for action in self._actions:
            needed = _NEEDED.match(action.help or "")
            if needed and action.dest in found.given and needed[1] not in found.given.values():
                self.error(f"{found.given[action.dest]} has no effect alone: add {needed[1]}.")
        return parsed

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.choices is None or value in action.choices:
            return
        choices = list(map(str, action.choices))
        flags = self._option_string_actions if isinstance(action, argparse._SubParsersAction) else []
        hint = _suggested(str(value), [*choices, *flags]) or f" Choose from {', '.join(choices)}."
        if isinstance(action, argparse._SubParsersAction):
            raise argparse.ArgumentError(None, f"There is no {str(action.metavar).lower()} {value!r:.80}.{hint}")
        raise argparse.ArgumentError(action, f"{value!r:.80} is not a choice.{hint}")

    def error(self, message: str) -> NoReturn:
        """End the process with one line on stderr."""
        line = " ".join(message.split())
        self.exit(
            WRONG_USAGE,
            f"{self.prog.split()[0]}: error: {line}{'' if line[-1] in '.?' else '.'} See {self.prog} --help.\n",
        )


def given_flags(arguments: argparse.Namespace, names: Collection[str]) -> list[str]:
    """Return the flags that are given, of those with these names of their values."""
    return [flag for name, flag in arguments.given.items() if name in names]


def check_there(paths: Iterable[object]) -> None:
    """Raise InputError for the first path that leads nowhere; addresses are not opened."""
    for path in paths:
        if path is not None and not is_address(path) and not os.path.lexists(split_dataset(str(path))[0]):
            raise InputError(f"{path}: there is no such file or folder. Check the name.")


def add_action(
    actions: argparse._SubParsersAction[Parser], name: str, command: Callable[..., None], text: str, **how: Any
) -> Parser:
    """Add an action of a command, described by a sentence."""
    parser = actions.add_parser(name, help=text, **{"description": f"{text[0].upper()}{text[1:]}.", **how})
    parser.set_defaults(command=command)
    return parser


def parsed(pattern: str, wanted: str, make: Callable[[re.Match[str]], Any]) -> Callable[[str], Any]:
    """The function that makes a value of a text of this pattern; of any other text, the error tells what is wanted."""

    def read(text: str) -> Any:
        match = re.fullmatch(pattern, text)
        made = None if match is None else make(match)
        if made is None:
            raise argparse.ArgumentTypeError(f"{text!r} is not {wanted}")
        return made

    return read


def _part(match: re.Match[str]) -> tuple[int, int] | None:
    number, count = int(match[1]), int(match[2])
    return (number, count) if 1 <= number <= count else None


_COUNT = parsed(r"0*[1-9]\d*", "an integer of at least 1", lambda match: int(match[0]))

_TEXT = parsed(r"(?s).+", "a name: is a variable empty?", lambda match: match[0])

VALUES: Mapping[str, Callable[[str], Any]] = {
    **dict.fromkeys(("N", "M"), _COUNT),
    **dict.fromkeys(("HZ", "UNITS", "WEIGHT"), float),
    "SEED": parsed(r"\d+", "an integer of at least 0", lambda match: int(match[0])),
    "A:B": parsed(
        r"(-?\d+)?:(-?\d+)?",
        "a range of frames, such as 100:200, :50 or -10:",
        lambda match: tuple(None if end is None else int(end) for end in match.groups()),
    ),
    "K/N": parsed(r"(\d+)/(\d+)", "a part K/N, such as 3/40", _part),
    "N,N,...": parsed(
        r"\d+(,\d+)*",
        "a list of block numbers, such as 3,7,12",
        lambda match: frozenset(map(int, match[0].split(","))),
    ),
}
"""What stands for a value in the help -> the function that reads the value; of all others, any text but "" is taken."""

_COUNTS = {(False, False): None, (True, False): "?", (False, True): "+", (True, True): "*"}
"""Whether a positional argument may be left out, and has several values -> how argparse says that."""

_DECLARED = re.compile(
    r"(?P<name>--\S+|\[?[A-Z][\w.]*\]?)(?: (?P<value>[^\s.]\S*))?(?P<repeats> \.\.\.\]?)?\s{2,}(?P<text>.+)"
)


def declare(group: argparse._ActionsContainer, text: str, only: Collection[str] = (), /, **defaults: Any) -> None:
    """Add arguments to a parser, or a group of them, that are declared as the help shows them.

    Parameters
    ----------
    group : argparse.ArgumentParser or a group of its arguments
    text : str
        Each argument begins a line, and its explanation follows after two blanks, and in indented lines below; one that
        begins with "required" makes a flag so, and "with --FLAG:" makes it need another. A flag without a value is a
        switch. Words joined by | are the choices;
        anything else, or words of capitals, stand for the value (see `VALUES`). After ..., a flag can be repeated, and
        a positional argument has several values; it may be left out in brackets.
    only : collection of str
        The flags that are added; all if there are none.
    **defaults
        Default values, by the names of the flags; the explanation ends with them. None if left out.

    Examples
    --------
    >>> parser = Parser()
    >>> declare(parser, "FILE ...  to play\\n--rate HZ  frames a second\\n--axes camera|world  of the cloud", rate=10.0)
    >>> found = parser.parse_args(["a.mcap", "b.mcap", "--axes", "world"])
    >>> found.files, found.rate, found.axes
    (['a.mcap', 'b.mcap'], 10.0, 'world')
    """
    for declared in re.split(r"\n(?=\S)", cleandoc(text)):
        found = _DECLARED.fullmatch(re.sub(r"\n\s+", " ", declared))
        assert found is not None, declared
        name, value, repeats, explanation = found.groups()
        has_opposite, name = name.startswith("--[no-]"), name.replace("[no-]", "")
        if only and name not in only:
            continue
        default = defaults.get(name[2:].replace("-", "_"))
        if default is not None:
            explanation += f" (default: {f'{default:g}' if isinstance(default, float) else default})"
        how: dict[str, Any] = {"help": explanation.replace("%", "%%")}
        if not name.startswith("--"):
            how |= {"metavar": name.strip("[]"), "nargs": _COUNTS[name.startswith("["), repeats is not None]}
            how |= {"type": _TEXT}
            name = re.split(r"\W", how["metavar"].lower())[0] + "s" * (repeats is not None)
        elif value is None:
            how |= {"action": argparse.BooleanOptionalAction if has_opposite else "store_true"}
        elif "|" in value and not re.fullmatch(r"[A-Z|]+", value):
            how |= {"choices": value.split("|"), "default": default}
        else:
            how |= {"metavar": value, "type": VALUES.get(value, _TEXT), "default": default}
            how |= {"required": explanation.startswith("required")}
            how |= {"action": "append", "default": []} if repeats else {}
        group.add_argument(name, **how)
