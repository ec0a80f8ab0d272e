"""The command qstereo-bridge: its words, many frames, pictures, pages, other tools' files."""
