"""Where the particles of a case may be: domain, floor, fills, walls, cells in plan."""
