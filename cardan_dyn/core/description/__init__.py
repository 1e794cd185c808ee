"""Description: text in any notation to checked plain data, and back to text.

`read` finds a text and chooses its reader. URDF: `urdf` with `elements`, `mimics`, `notations`
(loops of URDF+, Isaac, ROS, closing frames; `gazebo` for joints of SDF), `transmissions` (rotors)
and `beside` (YAML files).
MJCF and SDF have rooms of their own; that of MJCF has MuJoCo parse and compile the text
(`compiled`) and reads the model. `words` knows all words of URDF and SDF (`words.json`), `left_out`
tells what wrenches do not consider. What they return is a `description`, plain data.
`origins` finds lengths and angles by name, and makes joints of them that scenes can hold.
`coupled_forces` reads what a coupling says of its forces, `bodies` finds links that move as one and
`together` adds masses up.
`second_reading` reads the numbers again for the proof and shares nothing with them; those of other
notations place what they find by `renumbered`. `write` writes. Shapes of links are read from the
text only when they are shown (`visuals`, which the rooms of MJCF and SDF have as well), each a
`visual`; files of meshes are the viewer's business.
"""
