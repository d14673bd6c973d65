"""Files of other programs as they say it: meshes of gmsh, VTU, INP and Nastran, solids of STEP."""
