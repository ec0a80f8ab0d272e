"""Both files, models, exact energies, merging, and the face for Python. Sees numpy and dimod."""
