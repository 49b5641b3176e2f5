"""The pixels of a simulated camera, compiled.

A ray goes through each pixel and meets the marker's plane; the signed distance of that point
from an edge, in pixels, through the error function of the blur gives the grey value. All kernels
call only what stands in this file, which is what numba's cache watches.
"""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from controllers.kernel_files import kept_kernel

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Image = NDArray[np.uint8]


_FAR: Final = 3.6
"""Beyond it the blurred step is 0 or 1 to a millionth, in units of the blur times √2."""

_PER_UNIT: Final = 128
_STEPS: Final = np.array(
    [0.5 * math.erfc(_FAR - k / _PER_UNIT) for k in range(math.ceil(2.0 * _FAR * _PER_UNIT) + 2)]
)
"""The blurred step from -`_FAR` on; between its points a straight line is right to 1e-5."""


@kept_kernel
def _step(distance: float) -> float:
    """Return the blurred step at a distance in units of the blur, 0 … 1."""
    if distance > _FAR:
        return 1.0
    if distance < -_FAR:
        return 0.0
    at = (distance + _FAR) * _PER_UNIT
    k = int(at)
    return float(_STEPS[k] + (at - k) * (_STEPS[k + 1] - _STEPS[k]))


@kept_kernel
def trace_rays(rays: Singles, focal: Floats, centre: Floats, distortion: Floats) -> None:
    """Fill the direction (x/z, y/z) of each pixel's ray.

    Newton's method on the distortion (Brown and Conrady), started at each pixel from the
    solution of its neighbour.

    Parameters
    ----------
    rays : ndarray, shape (height, width, 2)
        Filled.
    focal, centre : ndarray, shape (2,)
        Focal lengths and principal point, pixels.
    distortion : ndarray, shape (5,)
        k1, k2, p1, p2, k3.
    """
    k1, k2, p1, p2, k3 = distortion
    for row in range(rays.shape[0]):
        target_y = (row - centre[1]) / focal[1]
        x, y = -centre[0] / focal[0], target_y
        for column in range(rays.shape[1]):
            target_x = (column - centre[0]) / focal[0]
            for _ in range(20):
                q = x * x + y * y
                g = 1.0 + k1 * q + k2 * q**2 + k3 * q**3
                slope = k1 + 2.0 * k2 * q + 3.0 * k3 * q**2  # of g over q
                error_x = x * g + 2.0 * p1 * x * y + p2 * (q + 2.0 * x * x) - target_x
                error_y = y * g + p1 * (q + 2.0 * y * y) + 2.0 * p2 * x * y - target_y
                xx = g + 2.0 * x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x
                xy = 2.0 * x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y
                yy = g + 2.0 * y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x
                determinant = xx * yy - xy * xy
                x -= (yy * error_x - xy * error_y) / determinant
                y -= (xx * error_y - xy * error_x) / determinant
                if abs(error_x) + abs(error_y) < 1e-14:
                    break
            rays[row, column, 0] = x
            rays[row, column, 1] = y


@kept_kernel
def cover_disc(
    cover: Singles, rays: Singles, poses: Floats, radius: float, focal: Floats, blur: float
) -> None:
    """Fill how much of each pixel a disc covers, averaged over the poses of an exposure.

    Parameters
    ----------
    cover : ndarray, shape (rows, columns)
        Filled, 0 … 1.
    rays : ndarray, shape (rows, columns, 2)
        Of the same window.
    poses : ndarray, shape (n, 3, 4)
        Axes x, y, z and centre of the marker as columns, in the camera's frame, m.
    radius : float
        m.
    focal : ndarray, shape (2,)
        Focal lengths, pixels.
    blur : float
        Point spread with the pixel's own width, rms, pixels.
    """
    cover[:] = 0.0
    share = 1.0 / poses.shape[0]
    far = 2.0 * (1.0001 * _FAR * blur) ** 2  # with room for what rounding does
    far_x, far_y = far / focal[0] ** 2, far / focal[1] ** 2
    for k in range(poses.shape[0]):
        nx, ny, nz = poses[k, 0, 2], poses[k, 1, 2], poses[k, 2, 2]
        cx, cy, cz = poses[k, 0, 3], poses[k, 1, 3], poses[k, 2, 3]
        height = nx * cx + ny * cy + nz * cz
        if height >= 0.0:  # it turns its back
            continue
        for row in range(cover.shape[0]):
            for column in range(cover.shape[1]):
                dx, dy = float(rays[row, column, 0]), float(rays[row, column, 1])
                fall = nx * dx + ny * dy + nz
                if fall > -1e-9:
                    continue
                s = height / fall
                x, y, z = s * dx - cx, s * dy - cy, s - cz
                square = x * x + y * y + z * z
                off = math.sqrt(square)
                if off < 1e-12:
                    cover[row, column] += share
                    continue
                # How fast the distance from the centre grows along a row and a column.
                toward = (x * dx + y * dy + z) / fall
                growth_x, growth_y = x - nx * toward, y - ny * toward
                # Most pixels are further from the edge than the blur reaches, which squares tell.
                reach = s * s * (growth_x * growth_x * far_x + growth_y * growth_y * far_y)
                if (radius - off) ** 2 * square > reach:
                    if off < radius:
                        cover[row, column] += share
                    continue
                along = s * growth_x / (off * focal[0])
                down = s * growth_y / (off * focal[1])
                slope = math.sqrt(along * along + down * down)
                inside = (radius - off) / (slope * blur * math.sqrt(2.0))
                cover[row, column] += share * _step(inside)


@kept_kernel
def cover_squares(
    cover: Singles,
    light: Singles,
    rays: Singles,
    poses: Floats,
    cells: Image,
    cell: float,
    focal: Floats,
    blur: float,
) -> None:
    """Fill how much of each pixel a pattern of square cells covers, and how light it is there.

    Parameters
    ----------
    cover, light : ndarray, shape (rows, columns)
        Filled, 0 … 1: covered by the pattern, and by its white cells.
    rays, poses, focal, blur
        As for `cover_disc`.
    cells : ndarray, shape (n, n)
        0 black, 1 white; row 0 is at the top, where the marker's y is greatest.
    cell : float
        Side of a cell, m.
    """
    cover[:] = 0.0
    light[:] = 0.0
    count = cells.shape[0]
    share = 1.0 / poses.shape[0]
    for k in range(poses.shape[0]):
        nx, ny, nz = poses[k, 0, 2], poses[k, 1, 2], poses[k, 2, 2]
        cx, cy, cz = poses[k, 0, 3], poses[k, 1, 3], poses[k, 2, 3]
        height = nx * cx + ny * cy + nz * cz
        if height >= 0.0:
            continue
        # From a ray to cells, a homography: the axes in cells, at the point where it meets.
        ax, ay, az = poses[k, 0, 0] / cell, poses[k, 1, 0] / cell, poses[k, 2, 0] / cell
        bx, by, bz = poses[k, 0, 1] / cell, poses[k, 1, 1] / cell, poses[k, 2, 1] / cell
        middle_u = 0.5 * count - (cx * ax + cy * ay + cz * az)
        middle_v = 0.5 * count + (cx * bx + cy * by + cz * bz)
        sharpness = focal[0] * cell / (blur * cz * math.sqrt(2.0))  # cells in units of the blur
        for row in range(cover.shape[0]):
            for column in range(cover.shape[1]):
                dx, dy = float(rays[row, column, 0]), float(rays[row, column, 1])
                fall = nx * dx + ny * dy + nz
                if fall > -1e-9:
                    continue
                s = height / fall
                u = middle_u + s * (ax * dx + ay * dy + az)
                v = middle_v - s * (bx * dx + by * dy + bz)
                if u < -1.0 or v < -1.0 or u > count + 1.0 or v > count + 1.0:
                    continue
                # A cell is much wider than the blur, so only the nearest edge of each matters,
                # and most pixels lie within one cell.
                left, top = int(u + 0.5) - 1, int(v + 0.5) - 1
                off_u, off_v = (u - left - 1.0) * sharpness, (v - top - 1.0) * sharpness
                if abs(off_u) > _FAR and abs(off_v) > _FAR:
                    i, j = left + (off_u > 0.0), top + (off_v > 0.0)
                    if 0 <= i < count and 0 <= j < count:
                        cover[row, column] += share
                        light[row, column] += share * cells[j, i]
                    continue
                right_share, low_share = _step(off_u), _step(off_v)
                for j in range(2):
                    part_v = share * (low_share if j else 1.0 - low_share)
                    if part_v == 0.0 or not 0 <= top + j < count:
                        continue
                    for i in range(2):
                        part = part_v * (right_share if i else 1.0 - right_share)
                        if part > 0.0 and 0 <= left + i < count:
                            cover[row, column] += part
                            light[row, column] += part * cells[top + j, left + i]


@kept_kernel
def expose(
    window: Image,
    scene: Singles,
    cover: Singles,
    light: Singles,
    noise: Singles,
    levels: Floats,
    read_variance: float,
    shot_variance: float,
) -> None:
    """Fill a window of an image: scene and marker, noise, eight bits.

    Parameters
    ----------
    window : ndarray of uint8, shape (rows, columns)
        Filled.
    scene : ndarray, shape (rows, columns)
        What is behind the marker, counts.
    cover, light : ndarray, shape (rows, columns)
        Parts of each pixel that the marker and its bright cells cover.
    noise : ndarray, shape (rows, columns)
        Standard normal.
    levels : ndarray, shape (2,)
        Of the marker's dark and bright parts, counts.
    read_variance, shot_variance : float
        Of a pixel in the dark, counts², and over its level, counts.
    """
    for row in range(window.shape[0]):
        for column in range(window.shape[1]):
            covered, lit = cover[row, column], light[row, column]
            level = (
                scene[row, column] * (1.0 - covered) + levels[0] * (covered - lit) + levels[1] * lit
            )
            spread = math.sqrt(read_variance + shot_variance * level)
            value = level + noise[row, column] * spread
            window[row, column] = np.uint8(min(max(math.floor(value + 0.5), 0.0), 255.0))
