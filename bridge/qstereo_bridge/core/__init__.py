"""Both files, models, exact energies, merging, and the face for Python. Of other packages it needs
numpy, dimod and google-crc32c."""
