"""`ilf bench`: completion, blocks and denoising compared with other methods, over many frames."""
