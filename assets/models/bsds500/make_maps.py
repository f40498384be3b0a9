"""Make the network's edge maps of BSDS500, for a boundary benchmark.

    python assets/models/bsds500/make_maps.py --data BSDS500 --model FOLDER/bsds500.onnx --out MAPS --split test

One `<number of the image>.npy` each, float32 (H, W) in [0, 1], not thinned. Needs no PyTorch.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

from ilf.segmentation.edges.detectors import EdgeNetwork

sys.path.insert(0, str(Path(__file__).parents[1]))
from recipes.bsds500_images import image_paths, load_examples, read_image


def main() -> None:
    """Write the maps of the test images, or of those held out from training, for model selection."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("--data", type=Path, required=True, help="folder of BSDS500, with images and groundTruth")
    parser.add_argument("--model", type=Path, required=True, help="the network as ONNX")
    parser.add_argument("--out", type=Path, required=True, help="folder of the maps")
    parser.add_argument("--split", choices=("held-out", "test"), default="held-out")
    parser.add_argument("--multiscale", action="store_true", help="average three scales")
    arguments = parser.parse_args()

    if arguments.split == "test":
        images = {path.stem: read_image(path) for path in image_paths(arguments.data, "test")}
    else:
        images = {example.name: example.rgb for example in load_examples(arguments.data)[1]}
    network = EdgeNetwork.load(arguments.model)
    arguments.out.mkdir(parents=True, exist_ok=True)
    for name, rgb in images.items():
        np.save(arguments.out / f"{name}.npy", network.strength(rgb, arguments.multiscale))


if __name__ == "__main__":
    main()
