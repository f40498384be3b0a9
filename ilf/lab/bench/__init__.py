"""The benches: completion, blocks and denoising, scored where depth is known."""
