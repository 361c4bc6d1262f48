"""Mazes: a spanning tree of cells, and some walls fewer."""

import numpy as np

from tasks.rooms.generators.connected import draw_connected
from tasks.rooms.generators.parts import THICKNESS, Rectangle, build_wall, enclose
from tasks.rooms.room import Obstacle, Room

CELL = (1.2, 1.8)  # m, from the middle of a wall to the next
CELLS = (4, 8)  # along a side, least and most
REMOVED = (0.0, 0.3)  # of the walls that a tree leaves

Edge = tuple[int, int, int]  # column and row of a cell, and the axis of the neighbour after it: 0 to the east, 1 north


def draw_maze(rng: np.random.Generator) -> Room:
    """Draw a maze of 4 to 8 cells a side, any two of which a way joins."""
    return draw_connected(_sketch, rng)


def _sketch(rng: np.random.Generator) -> list[Obstacle]:
    cell = rng.uniform(*CELL)
    columns, rows = rng.integers(CELLS[0], CELLS[1] + 1, 2).tolist()
    left = 1.0 - rng.uniform(*REMOVED)
    closed = [edge for edge in _close_edges(rng, columns, rows) if rng.random() < left]
    west, south, half = -columns * cell / 2, -rows * cell / 2, THICKNESS / 2
    walls = enclose(Rectangle(west + half, south + half, -west - half, -south - half))
    for column, row, axis in closed:
        x, y = west + column * cell, south + row * cell
        at, begin = (x + cell, y) if axis == 0 else (y + cell, x)
        walls += build_wall(1 - axis, at, (begin - half, begin + cell + half))
    return walls


def _close_edges(rng: np.random.Generator, columns: int, rows: int) -> list[Edge]:
    """Edges between neighbours that no random spanning tree needs, by Kruskal's algorithm."""
    edges: list[Edge] = [(column, row, 0) for column in range(columns - 1) for row in range(rows)]
    edges += [(column, row, 1) for column in range(columns) for row in range(rows - 1)]
    parent = list(range(columns * rows))

    def root(cell: int) -> int:
        while parent[cell] != cell:
            parent[cell] = cell = parent[parent[cell]]
        return cell

    closed = []
    for number in rng.permutation(len(edges)).tolist():
        column, row, axis = edges[number]
        cell = column * rows + row
        here, there = root(cell), root(cell + (rows if axis == 0 else 1))
        if here == there:
            closed.append(edges[number])
        parent[here] = there
    return closed
