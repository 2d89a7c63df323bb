"""The colours of results: of methods, of what is right, what is free and what failed."""

Color = tuple[int, int, int]

GOOD: Color = (0, 160, 112)
FREE: Color = (240, 228, 66)  # motions that nothing determines, and the views they leave ambiguous
BAD: Color = (240, 90, 40)  # failed views, wrong matches, contradicted edges, outliers

# Methods. After Okabe and Ito: the colour-blind tell them apart. A contrast of 3:1 on white, black, the 3D background.
ICP: Color = (208, 128, 0)
RANSAC_ICP: Color = (70, 140, 225)
PAIRWISE: Color = (0, 160, 112)
REFINED: Color = (204, 121, 167)
