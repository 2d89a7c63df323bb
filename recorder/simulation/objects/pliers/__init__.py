"""Pliers lying flat, 9 to 28 cm long, jaws towards +x: shut to wide open."""

from orbitscan.recorder.simulation.objects.pliers.adjustable import locking, slip_joint, tongue_and_groove
from orbitscan.recorder.simulation.objects.pliers.combination import combination
from orbitscan.recorder.simulation.objects.pliers.fixed import cutters, mini, needle_nose

STYLES = (combination, slip_joint, needle_nose, cutters, tongue_and_groove, locking, mini)
