"""The figures of the table experiment, and its words."""

from __future__ import annotations

from ..parameters import PRESETS
from .experiment import METHOD_PRESETS, PAPER_PRESETS, Comparison, Drawing, Result, Row
from .plots import colour_of, legend, panels
from .table import ALL_BLOCKS, SELECTIVE
from .verdicts import counted, how_it_compares, lowest, millimetres, percent

_PAPER = {"rmse_mm": 300.224, "mae_mm": 173.014, "rel": 0.008}
_PAPER_PEER = {"rmse_mm": 1962.779, "mae_mm": 1935.296, "rel": 0.701}
_PAPER_BLOCKS = 9409


def draw_table(result: Result) -> list[Drawing]:
    """Bars of RMSE and MAE over all blocks, and the selective mean beside the fair one."""
    return [_draw_all(result.rows), _draw_selective(result.rows)]


def _draw_all(rows: list[Row]) -> Drawing:
    rows = [row for row in rows if row["scope"] == ALL_BLOCKS]
    patterns = list(dict.fromkeys(row["pattern"] for row in rows))
    figure, axes = panels(1, len(patterns), width=4.3, height=4.4)
    for ax, pattern in zip(axes, patterns, strict=True):
        mine = sorted((row for row in rows if row["pattern"] == pattern), key=lambda row: -row["rmse_mm"])
        places = range(len(mine))
        colours = [colour_of(row["method"]) if row["method"] in PRESETS else "#b8bec6" for row in mine]
        ax.barh([place + 0.2 for place in places], [row["rmse_mm"] for row in mine], 0.38, color=colours)
        ax.barh([place - 0.2 for place in places], [row["mae_mm"] for row in mine], 0.38, color=colours, alpha=0.5)
        for place, row in enumerate(mine):
            ax.annotate(
                f" {row['rmse_mm']:.0f} / {row['mae_mm']:.1f}", (row["rmse_mm"], place), fontsize=7, va="center"
            )
        ax.set_yticks(places, [row["method"] for row in mine])
        ax.set_xlim(0, 1.3 * mine[0]["rmse_mm"])
        ax.grid(False, axis="y")
        ax.set_xlabel("RMSE / MAE (paler) [mm]")
        ax.set_title(
            f"{pattern}: {counted(mine[0]['frames'], 'frame')}, {counted(mine[0]['blocks'], 'block')}", fontsize=9
        )
    caption = "RMSE and MAE over all operation blocks, weighted by pixels; the presets in colour, the peers in grey."
    return Drawing("all-blocks", caption, figure)


def _draw_selective(rows: list[Row]) -> Drawing:
    fair = {(row["pattern"], row["method"]): row for row in rows if row["scope"] == ALL_BLOCKS}
    pairs = [row for row in rows if row["scope"] == SELECTIVE and row["method"] == "paper" and row["blocks"]]
    patterns = list(dict.fromkeys(row["pattern"] for row in pairs))
    figure, axes = panels(1, max(len(patterns), 1), width=4.3, height=4.2)
    for ax, pattern in zip(axes, patterns, strict=False):
        mine = [row for row in pairs if row["pattern"] == pattern]
        places = range(len(mine))
        series = (
            ("paper, all blocks", [fair[pattern, "paper"]["rmse_mm"]] * len(mine), "#d1495b", 0.5),
            ("paper, blocks it wins", [row["rmse_mm"] for row in mine], "#d1495b", 1.0),
            ("peer, all blocks", [fair[pattern, row["peer"]]["rmse_mm"] for row in mine], "#7d8791", 0.5),
            ("peer, the same blocks", [row["peer_rmse_mm"] for row in mine], "#7d8791", 1.0),
        )
        for offset, (label, values, colour, alpha) in zip((0.3, 0.1, -0.1, -0.3), series, strict=True):
            ax.barh([place + offset for place in places], values, 0.18, color=colour, alpha=alpha, label=label)
        ax.set_yticks(places, [f"{row['peer']} ({row['share_won']:.0%} won)" for row in mine])
        ax.grid(False, axis="y")
        ax.set_xlabel("RMSE [mm]")
        ax.set_title(pattern, fontsize=9)
    legend(figure, axes[0], columns=4)
    caption = (
        "What the paper's selection does: the mean over all blocks (pale) beside the mean over only those blocks where "
        "the preset paper has the smaller RMSE (full)."
    )
    return Drawing("selective", caption, figure)


def compare_table(rows: list[Row]) -> list[Comparison]:
    """The fair and the selective mean beside the paper's table."""
    comparisons = []
    for pattern in dict.fromkeys(row["pattern"] for row in rows):
        fair = {row["method"]: row for row in rows if row["pattern"] == pattern and row["scope"] == ALL_BLOCKS}
        chosen = [row for row in rows if row["pattern"] == pattern and row["scope"] == SELECTIVE]
        for method in METHOD_PRESETS:
            comparisons.append(_fair(pattern, method, fair))
        for method in METHOD_PRESETS:
            comparisons.append(_selective(pattern, method, fair, [row for row in chosen if row["method"] == method]))
    return comparisons


def _values(row: Row, prefix: str = "") -> str:
    rmse, mae, rel = (row[prefix + name] for name in ("rmse_mm", "mae_mm", "rel"))
    return f"RMSE {millimetres(rmse)}, MAE {millimetres(mae)}, Rel {rel:.4f}"


def _published(values: Row) -> str:
    return f"RMSE {values['rmse_mm']} mm, MAE {values['mae_mm']} mm, Rel {values['rel']}"


def _fair(pattern: str, method: str, fair: dict[str, Row]) -> Comparison:
    row = fair[method]
    place = sorted(fair.values(), key=lambda other: other["rmse_mm"]).index(row) + 1
    winner = lowest((other for name, other in fair.items() if name != method), lambda other: other["rmse_mm"])
    relation = "behind" if winner["rmse_mm"] < row["rmse_mm"] else "ahead of"
    text = f"Number {place} of {len(fair)} methods by RMSE, {relation} {winner['method']} "
    text += f"({millimetres(winner['rmse_mm'])}). "
    if pattern == "random":
        text += (
            f"RMSE is {how_it_compares(row['rmse_mm'], _PAPER['rmse_mm'])}, but the paper's numbers are over other "
            f"frames and over won blocks only; its {_PAPER_BLOCKS} blocks stand against {row['blocks']} here."
        )
        paper = f"{_published(_PAPER)} (won blocks only)"
    else:
        text += f"{counted(row['blocks'], 'block')} of {counted(row['frames'], 'frame')}; "
        text += "the paper's table has no such pattern."
        paper = "not measured"
    return Comparison(f"All blocks, {pattern}, {method}", paper, _values(row), text)


def _selective(pattern: str, method: str, fair: dict[str, Row], pairs: list[Row]) -> Comparison:
    """Against the peer from which selecting gains most."""
    shares = [row["share_won"] for row in pairs]
    span = f"{percent(round(min(shares), 3))} (against {lowest(pairs, lambda row: row['share_won'])['peer']}) to "
    span += f"{percent(round(max(shares), 3))} (against {lowest(pairs, lambda row: -row['share_won'])['peer']})"
    where = [row for row in pairs if row["blocks"]]
    text = f"It wins {span} of the blocks. "
    ours = "no block won"
    if where:
        row = max(where, key=lambda item: _ratio(item) / _fair_ratio(item, fair))
        ours = f"{_values(row)} against {row['peer']}: {_values(row, 'peer_')} "
        ours += f"({row['blocks']} of {fair[method]['blocks']} blocks)"
        text += (
            f"The selection changes most against {row['peer']}: over all blocks the peer's RMSE is "
            f"{_fair_ratio(row, fair):.2f} times that of {method}, over the won blocks alone {_ratio(row):.2f} times. "
            "A mean over won blocks favours whoever selects, whatever the methods are."
        )
        if method in PAPER_PRESETS and pattern == "random":
            text += f" Rel without the weight by pixels, as the paper takes it, would be {row['rel_unweighted']:.4f}."
    return Comparison(
        f"Selective mean as in the paper, {pattern}, {method}",
        f"ILF {_published(_PAPER)}; NLSPN {_published(_PAPER_PEER)} ({_PAPER_BLOCKS} blocks)"
        if pattern == "random"
        else "not measured",
        ours,
        text,
    )


def _ratio(row: Row) -> float:
    return float(row["peer_rmse_mm"] / max(row["rmse_mm"], 1e-9))


def _fair_ratio(row: Row, fair: dict[str, Row]) -> float:
    return float(fair[row["peer"]]["rmse_mm"] / max(fair[row["method"]]["rmse_mm"], 1e-9))
