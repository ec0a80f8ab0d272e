"""Calibrations for the tests of the camera's commands, and files of OpenCV's FileStorage that hold
them, written by OpenCV itself.
"""

import cv2
import numpy as np

SIZE = (96, 64)  # width and height

# Coefficients of lenses by how many there are.
LENSES = {
    0: [],
    4: [-0.11, 0.03, 0.0011, -0.0007],
    5: [-0.21, 0.07, 0.0012, -0.0008, 0.012],
    8: [0.21, -0.05, 0.0008, 0.0005, 0.013, 0.35, -0.04, 0.011],
    14: [0.2, -0.05, 0.0008, 0.0005, 0.01, 0.3, -0.04, 0.01, 0.002, -0.001, 0.0015, 0.001, 0, 0],
}


def matrix(fx, fy, cx, cy):
    return np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])


def calibration(coefficients=5, size=SIZE):
    """The matrices of a pair of cameras that look nearly the same way, 0.12 apart."""
    width, height = size
    scale = width / 96
    turn, _ = cv2.Rodrigues(np.array([0.011, -0.024, 0.017]))
    lens = np.array(LENSES[coefficients], float).reshape(1, -1)
    return {
        "K1": matrix(92.3 * scale, 91.8 * scale, width * 0.51, height * 0.48),
        "D1": lens,
        "K2": matrix(90.7 * scale, 90.4 * scale, width * 0.49, height * 0.53),
        "D2": lens * 0.9,
        "R": turn,
        "T": np.array([[-0.12], [0.002], [-0.003]]),
    }


def write_storage(path, values):
    """Writes matrices, lists of numbers and numbers by their names, as OpenCV does."""
    file = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    for name, value in values.items():
        file.write(name, value)
    file.release()
    return path


def rectified(of, size=SIZE):
    """R1, R2, P1 and P2 of OpenCV's stereoRectify with alpha = 0."""
    found = cv2.stereoRectify(
        of["K1"], of["D1"], of["K2"], of["D2"], size, of["R"], of["T"],
        flags=cv2.CALIB_ZERO_DISPARITY, alpha=0,
    )
    return dict(zip(("R1", "R2", "P1", "P2"), found))


def remapped(of, side, picture):
    """A picture of camera 1 or 2 as OpenCV rectifies it; `of` has R1, R2, P1 and P2."""
    maps = cv2.initUndistortRectifyMap(
        of[f"K{side}"], of[f"D{side}"], of[f"R{side}"], of[f"P{side}"],
        picture.shape[1::-1], cv2.CV_32FC1,
    )
    return cv2.remap(picture, *maps, cv2.INTER_LINEAR), maps


def write_pfm(path, values):
    """Writes a little-endian PFM of an array whose rows go from the top."""
    header = f"Pf\n{values.shape[1]} {values.shape[0]}\n-1.0\n".encode()
    path.write_bytes(header + values[::-1].astype("<f4").tobytes())
    return path


def read_ply(path):
    """The points of a binary PLY and their colours, None if it has none."""
    head, data = path.read_bytes().split(b"end_header\n", 1)
    lines = head.decode().splitlines()
    assert lines[:2] == ["ply", "format binary_little_endian 1.0"]
    count = next(int(line.split()[2]) for line in lines if line.startswith("element vertex "))
    kinds = {"float": "<f4", "uchar": "u1"}
    fields = [line.split()[1:] for line in lines if line.startswith("property ")]
    table = np.frombuffer(data, [(name, kinds[kind]) for kind, name in fields])
    assert len(table) == count
    points = np.stack([table[name] for name in "xyz"], axis=1)
    if "red" not in table.dtype.names:
        return points, None
    return points, np.stack([table[name] for name in ("red", "green", "blue")], axis=1)


def write_calib(path, size=(12, 8), doffs=3.5, ndisp=5):
    """Writes a calib.txt as Middlebury's scenes of 2014 have it."""
    path.write_text(
        f"cam0=[50 0 5.5; 0 50 3.5; 0 0 1]\ncam1=[50 0 {5.5 + doffs}; 0 50 3.5; 0 0 1]\n"
        f"doffs={doffs}\nbaseline=193.001\nwidth={size[0]}\nheight={size[1]}\nndisp={ndisp}\n"
        "isint=0\nvmin=1\nvmax=4\ndyavg=0\ndymax=0\n"
    )
    return path
