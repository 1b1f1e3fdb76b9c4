# SPDX-License-Identifier: Apache-2.0
"""A picture of a path, with matplotlib."""
import numpy as np


def plot(trajectory, truth=None, ax=None, align='se3'):
    """Draws a Trajectory from above (x to the right, z up), and the truth if it is given, to which it is aligned.

    Without a truth each submap is a line: they are worlds of their own, and nobody knows where one lies in another.
    Returns the matplotlib axes: `covis.plot(path).figure.savefig('path.png')`. Matplotlib is needed for this alone.
    """
    from . import _covis
    if ax is None:
        from matplotlib.figure import Figure
        ax = Figure(figsize=(7, 7)).add_subplot()
    if truth is None:
        submaps, sizes = np.unique(trajectory.submaps, return_counts=True)
        largest_first = submaps[np.argsort(-sizes, kind='stable')]
        for rank, submap in enumerate(largest_first if len(largest_first) else [0]):
            position = trajectory.positions[trajectory.submaps == submap]
            ax.plot(position[:, 0], position[:, 2], label=f'submap {submap}, another world' if rank else 'Covis',
                    alpha=0.5 if rank else 1)
    else:
        compared = _covis.evaluate(trajectory, truth, align=align)
        # The plane in which the true path goes farthest.
        first, second = sorted(range(3), key=lambda k: -np.ptp(compared.truth[:, k]))[:2]
        first, second = min(first, second), max(first, second)
        ax.plot(compared.truth[:, first], compared.truth[:, second], color='0.6', label='truth')
        ax.plot(compared.estimate[:, first], compared.estimate[:, second], label=f'Covis, ATE {compared.ate_rmse:.4f} m')
    ax.set_aspect('equal', adjustable='datalim')
    ax.set_xlabel('metres')
    ax.legend()
    return ax
