//! Keyframes by what they look like.

use geometry::SE3;

use super::*;
use crate::scene::{Scene, Shot, described, shot};

/// A scene of 90 landmarks, and a database of three keyframes: the first two thirds, the last two thirds, all of them.
fn database() -> (Scene, KeyframeDatabase) {
    let scene = Scene::wall(90);
    let mut database = described(Map::new()).places;
    for (id, range) in [(0, 0..60), (1, 30..90), (70, 0..90)] {
        database.add(KeyframeId(id), &frame(&scene, range));
    }
    (scene, database)
}

fn frame(scene: &Scene, range: std::ops::Range<usize>) -> Arc<Frame> {
    scene.frame(0, &SE3::identity(), &range.map(shot).collect::<Vec<Shot>>())
}

fn alike(scene: &Scene, database: &KeyframeDatabase, unwanted: u32) -> Vec<(u32, f64)> {
    let seen = database.describe(&frame(scene, 0..60)).unwrap();
    database.alike(&seen.bow, |id| id.0 != unwanted).iter().map(|a| (a.keyframe.0, a.score)).collect()
}

#[test]
fn the_most_similar_come_first() {
    let (scene, database) = database();
    let found = alike(&scene, &database, 99);
    assert_eq!(found.iter().map(|f| f.0).collect::<Vec<_>>(), vec![0, 70, 1]);
    assert!((found[0].1 - 1.0).abs() < 1e-6 && found[1].1 < 0.9 && found[2].1 < found[1].1, "{found:?}");
    assert_eq!(alike(&scene, &database, 0).iter().map(|f| f.0).collect::<Vec<_>>(), vec![70, 1]);
}

#[test]
fn what_is_added_twice_stays_and_what_is_removed_is_gone() {
    let (scene, mut database) = database();
    let before = alike(&scene, &database, 99);
    database.add(KeyframeId(1), &frame(&scene, 0..60));
    assert_eq!(alike(&scene, &database, 99), before);
    let snapshot = database.clone();
    database.remove(KeyframeId(0));
    assert!(database.of(KeyframeId(0)).is_none() && database.of(KeyframeId(70)).is_some());
    assert_eq!(alike(&scene, &database, 99).len(), 2);
    assert_eq!(alike(&scene, &snapshot, 99), before, "a snapshot stays as it was");
}

#[test]
fn distrusted_features_count_less_where_words_are_weighted() {
    let (scene, mut plain) = database();
    plain.add(KeyframeId(2), &frame(&scene, 30..60));
    let weighted = plain.clone().weighted(true);
    let mut frame = (*frame(&scene, 0..60)).clone();
    frame.lasting = (0..60).map(|i| if i < 30 { 0.01 } else { 1.0 }).collect();
    let score_of_2 = |database: &KeyframeDatabase| {
        let seen = database.describe(&frame).unwrap();
        database.alike(&seen.bow, |id| id.0 == 2)[0].score
    };
    assert!(score_of_2(&weighted) > score_of_2(&plain) + 0.2);
}

#[test]
fn without_a_vocabulary_nothing_is_described() {
    let (scene, _) = database();
    let mut database = KeyframeDatabase::new(None);
    database.add(KeyframeId(0), &frame(&scene, 0..60));
    assert!(database.describe(&frame(&scene, 0..60)).is_none() && database.of(KeyframeId(0)).is_none());
}
