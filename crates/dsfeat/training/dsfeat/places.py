"""Place recognition: loops of a sequence from dense descriptors, verified by geometry and by their neighbours.

The paper finds loop candidates with a bag of words of SuperPoint features and verifies them in a topological graph. Here
the words are clusters of XFeat's dense descriptors (free of SuperPoint's licence), the graph check asks that the frames
before and after the query lead to frames before and after the loop as well.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from .matching import Features, features, pair

#: Words, and rounds of k-means.
WORDS, ROUNDS = 64, 12
#: Inliers that a loop needs, and the most that a negative may have.
LEAST_INLIERS, MOST_INLIERS = 30, 15
#: Candidates per query that are verified.
CANDIDATES = 3


@dataclass
class Loop:
    """Frames of one place at two times, with the number of matches that obey the epipolar geometry."""

    query: int
    match: int
    inliers: int


def vocabulary(descriptors: np.ndarray, seed: int = 1) -> np.ndarray:
    """Words [WORDS, C] of unit descriptors [N, C] by k-means."""
    cv2.setRNGSeed(seed)
    criteria = (cv2.TERM_CRITERIA_MAX_ITER, ROUNDS, 0)
    return cv2.kmeans(descriptors.astype(np.float32), WORDS, None, criteria, 1, cv2.KMEANS_PP_CENTERS)[2]


def bags(descriptors: np.ndarray, words: np.ndarray) -> np.ndarray:
    """VLAD vectors [N, WORDS * C] of the descriptors [N, P, C]: sums of the differences to the nearest word, power-normalised."""
    out = np.zeros((len(descriptors), *words.shape), np.float32)
    for i, one in enumerate(descriptors.astype(np.float32)):
        nearest = np.argmax(one @ words.T - 0.5 * np.square(words).sum(axis=1), axis=1)
        np.add.at(out[i], nearest, one - words[nearest])
    out = out.reshape(len(out), -1)
    out = np.sign(out) * np.sqrt(np.abs(out))
    return out / np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-9)


def similarities(vectors: np.ndarray) -> np.ndarray:
    """Cosine similarity [N, N] of the frames' vectors, without their common mean."""
    centred = vectors - vectors.mean(axis=0)
    centred /= np.maximum(np.linalg.norm(centred, axis=1, keepdims=True), 1e-9)
    return centred @ centred.T


def consistent(best: np.ndarray, query: int, match: int, reach: int = 3) -> bool:
    """Whether a neighbour of the query leads near the match too (the topological check); `best` [N] is each frame's match."""
    near = [i for i in (query - 2, query - 1, query + 1, query + 2) if 0 <= i < len(best)]
    return sum(abs(int(best[i]) - match) <= reach for i in near) >= min(2, len(near))


def find_loops(scores: np.ndarray, found: list[Features], gap: int) -> list[Loop]:
    """Verified loops of frames more than `gap` apart, best candidate first."""
    count = len(found)
    apart = np.abs(np.arange(count)[:, None] - np.arange(count)[None]) > gap
    allowed = np.where(apart, scores, -2.0)
    best = allowed.argmax(axis=1)
    loops = []
    for query in range(count):
        for match in np.argsort(-allowed[query], kind="stable")[:CANDIDATES]:
            if allowed[query, match] <= -1.0 or not consistent(best, query, int(match)):
                continue
            inliers = pair(found[query], found[match]).inliers
            if inliers >= LEAST_INLIERS:
                loops.append(Loop(query, int(match), inliers))
                break
    return loops


def find_negative(scores: np.ndarray, found: list[Features], loop: Loop, gap: int, rng: np.random.Generator) -> tuple[int, int] | None:
    """A frame of another place, rather similar but geometrically unrelated to the query, and its number of inliers."""
    frames = np.arange(len(found))
    far = (np.abs(frames - loop.query) > gap) & (np.abs(frames - loop.match) > gap)
    order = frames[far][np.argsort(-scores[loop.query][far], kind="stable")]
    for negative in rng.permutation(order[: max(5, len(order) // 2)])[:10]:
        inliers = pair(found[loop.query], found[negative]).inliers
        if inliers <= MOST_INLIERS:
            return int(negative), inliers
    return None


def features_of(images: list[np.ndarray]) -> list[Features]:
    """ORB features of all frames."""
    return [features(image) for image in images]
