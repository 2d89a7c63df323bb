"""FPFH descriptors, computed by Open3D (Rusu et al., ICRA 2009). Not part of the registration: for comparisons."""

import numpy as np
from scipy.spatial import cKDTree

from orbitscan.recorder.libraries import load_open3d

LENGTH = 33


def describe(points: np.ndarray, normals: np.ndarray, keypoints: np.ndarray, radius: float) -> np.ndarray:
    """Descriptors (K, 33) float32 of the keypoints (K, 3): three histograms of 11 bins, each of sum 200.

    Of the points (N, 3), with unit normals (N, 3), those with a normal within the radius [m] count. A keypoint is one
    of them; any other place takes the values of the nearest. NaN where none lies within the radius, or the nearest has
    no neighbour. Raises MissingLibrary where Open3D does not load.

    Open3D's values are PCL's plus the keypoint's own simple histograms (SPFH), which PCL leaves out: there each
    histogram's sum is 100. With the SPFH taken off, the two agree to 1e-6 of that sum.
    """
    open3d = load_open3d("choose another descriptor")
    descriptors = np.full((len(keypoints), LENGTH), np.nan, np.float32)
    known = np.isfinite(normals).all(axis=1)
    if not known.any() or not len(keypoints):
        return descriptors
    cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points[known]))
    cloud.normals = open3d.utility.Vector3dVector(normals[known])
    search = open3d.geometry.KDTreeSearchParamRadius(radius)
    everywhere = open3d.pipelines.registration.compute_fpfh_feature(cloud, search).data.T  # (n, 33)
    distance, nearest = cKDTree(points[known]).query(keypoints)
    found = (distance < radius) & everywhere[nearest].any(axis=1)
    descriptors[found] = everywhere[nearest[found]]
    return descriptors
