"""Description: text to checked plain data, and back to text.

`read` finds a text and chooses its reader. URDF: `urdf` with `elements`, `mimics`, `notations`
(loops of URDF+, Isaac, ROS, closing frames), `transmissions` (rotors) and `beside` (YAML files).
Whatever else is a text of a guest (`GUESTS`), joints of SDF in a URDF's `<gazebo>` as well.
`words` knows all words of URDF and SDF (`words.json`), `left_out` tells what wrenches do not
consider. What they return is a `description`, plain data.
`origins` finds lengths and angles by name, and makes joints of them that scenes can hold.
`coupled_forces` reads what a coupling says of its forces, `bodies` finds links that move as one.
`second_reading` reads the numbers again for the proof and shares nothing with them. `write` writes.
"""
