"""Pictures in numpy: label maps, stages of the extraction, point clouds."""
