"""Viewer: mechanisms turning with their moments drawn on them, in meshcat.

Needs the extra `viz`.

`viewer` draws sweeps, trajectories, configurations (`still`) and `mode_shapes`. `viewing` is the
face; `scenery` collects on a `Drawing` (`commands`) what is drawn, what it means and what the
camera has to see: `bodies` with the `visuals` of links (`meshes` finds and reads their files, and
makes them coarser) or with `default_shapes` made up from joints; `vectors` at joints, and at
`places` of coordinates and links `load_shapes` and `element_shapes`. All are surfaces, of which
`shapes` makes those that no file has. `readings` are what the page tells beside the picture: its
course, state and the numbers of joints. All goes into one HTML file as JSON and an array of bytes,
with three.js. The page is `templates/scene.html`; its scripts are parts of one, in this order:
`data` (reads what Python wrote), `colors`, `stage` (nodes, poses, what is shown), `camera`,
`labels` (where names find room), `graph`, `panel` (list, slider, keys). They hold no mechanics:
what a number means is decided in Python. `tests/behaviour/test_scene_page.py` uses the page in a
browser, by `window.scene`.
"""
