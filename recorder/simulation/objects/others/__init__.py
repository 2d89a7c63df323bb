"""Other household things, none of the ten categories: what a classifier learns, or is tested, not to know.

Each is one function from a random generator to a coloured mesh in real sizes as it stands or lies on a table, its front
towards +x.
"""

from orbitscan.recorder.simulation.objects.others.desk import camera, computer_mouse, desk_lamp, headphones, keyboard
from orbitscan.recorder.simulation.objects.others.food import banana, bread_loaf, mushroom, pear
from orbitscan.recorder.simulation.objects.others.house import ball, comb, hand_towel, shoe, sponge, toothbrush, toy_car
from orbitscan.recorder.simulation.objects.others.kitchen import fork, frying_pan, pitcher, plate, spoon, wine_glass
from orbitscan.recorder.simulation.objects.others.packages import (
    cereal_box,
    food_bag,
    food_can,
    milk_carton,
    soda_can,
    tissue_box,
)
from orbitscan.recorder.simulation.objects.others.stationery import calculator, marker, stapler, tape_roll
from orbitscan.recorder.simulation.objects.others.tools import flashlight, hammer, light_bulb, scissors, screwdriver

BUILDERS = (
    ball,
    banana,
    bread_loaf,
    calculator,
    camera,
    cereal_box,
    comb,
    computer_mouse,
    desk_lamp,
    flashlight,
    food_bag,
    food_can,
    fork,
    frying_pan,
    hammer,
    hand_towel,
    headphones,
    keyboard,
    light_bulb,
    marker,
    milk_carton,
    mushroom,
    pear,
    pitcher,
    plate,
    scissors,
    screwdriver,
    shoe,
    soda_can,
    sponge,
    spoon,
    stapler,
    tape_roll,
    tissue_box,
    toothbrush,
    toy_car,
    wine_glass,
)
