//! What `evo` 1.38.1 prints (`evo_ape`, `evo_rpe` with `--save_results`) for the fixtures and the published trajectories.

use dsslam_eval::Alignment::{self, None, Se3, Sim3};
use dsslam_eval::DeltaUnit::{self, Frames, Meters};
use dsslam_eval::PairMode::{self, All, Consecutive};

/// Which part of a relative pose error.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Part {
    Translation,
    Rotation,
}
use Part::{Rotation, Translation};

/// One line of `evo_ape`.
#[derive(Debug)]
pub(crate) struct Ape {
    pub(crate) gt: &'static str,
    pub(crate) est: &'static str,
    pub(crate) alignment: Alignment,
    pub(crate) rmse: f64,
    pub(crate) mean: f64,
    pub(crate) median: f64,
    pub(crate) std: f64,
    pub(crate) max: f64,
    pub(crate) n: usize,
}

/// One line of `evo_rpe`; the last of the options is `--pairs_from_reference`.
#[derive(Debug)]
pub(crate) struct Rpe {
    pub(crate) gt: &'static str,
    pub(crate) est: &'static str,
    pub(crate) alignment: Alignment,
    pub(crate) options: (f64, DeltaUnit, PairMode, bool),
    pub(crate) part: Part,
    pub(crate) rmse: f64,
    pub(crate) mean: f64,
    pub(crate) median: f64,
    pub(crate) std: f64,
    pub(crate) max: f64,
    pub(crate) n: usize,
}

#[rustfmt::skip]
pub(crate) const FIXTURES_APE: &[Ape] = &[
    Ape { gt: "kitti_gt.txt", est: "kitti_est.txt", alignment: None, rmse: 1.6295734152481112, mean: 1.3737114238947499, median: 1.4516609297801573, std: 0.8765993609080786, max: 2.8608544759590133, n: 300 },
    Ape { gt: "kitti_gt.txt", est: "kitti_est.txt", alignment: Se3, rmse: 0.4943276598546963, mean: 0.4158926714535564, median: 0.34924849653390927, std: 0.26719491224318725, max: 0.9947534800158144, n: 300 },
    Ape { gt: "kitti_gt.txt", est: "kitti_est.txt", alignment: Sim3, rmse: 0.17930630857493957, mean: 0.15859104874224228, median: 0.13784781119197076, std: 0.08366380073608407, max: 0.4362798106839026, n: 300 },
    Ape { gt: "tum_gt.txt", est: "tum_est.txt", alignment: Se3, rmse: 4.823273729748702, mean: 4.434649799228873, median: 4.767445189153402, std: 1.896800102879396, max: 7.205624659963022, n: 86 },
    Ape { gt: "tum_gt.txt", est: "tum_est.txt", alignment: Sim3, rmse: 0.01763726618825193, mean: 0.015635896525921622, median: 0.01299040314823427, std: 0.008160385923835162, max: 0.04350411947534937, n: 86 },
    Ape { gt: "euroc_gt.csv", est: "tum_est.txt", alignment: Sim3, rmse: 0.01763726618825193, mean: 0.015635896525921622, median: 0.01299040314823427, std: 0.008160385923835162, max: 0.04350411947534937, n: 86 },
];

#[rustfmt::skip]
pub(crate) const FIXTURES_RPE: &[Rpe] = &[
    Rpe { gt: "kitti_gt.txt", est: "kitti_est.txt", alignment: None, options: (1.0, Frames, Consecutive, false), part: Translation, rmse: 0.01817337464298135, mean: 0.0167547033176099, median: 0.016378736355449328, std: 0.0070392799811507195, max: 0.04415946452320834, n: 299 },
    Rpe { gt: "kitti_gt.txt", est: "kitti_est.txt", alignment: None, options: (1.0, Frames, Consecutive, false), part: Rotation, rmse: 0.0485829302799714, mean: 0.044781368872606586, median: 0.04327611286427687, std: 0.01883958907418373, max: 0.10767437877715644, n: 299 },
    Rpe { gt: "kitti_gt.txt", est: "kitti_est.txt", alignment: None, options: (10.0, Meters, Consecutive, false), part: Translation, rmse: 0.07666752280422108, mean: 0.07288386309728807, median: 0.07218868029158126, std: 0.023787634454723105, max: 0.11083346618301994, n: 30 },
    Rpe { gt: "kitti_gt.txt", est: "kitti_est.txt", alignment: None, options: (10.0, Meters, All, false), part: Translation, rmse: 0.07487720550003685, mean: 0.0709107599197737, median: 0.07230332345612485, std: 0.024047037886088186, max: 0.13174274678872744, n: 291 },
    Rpe { gt: "tum_gt.txt", est: "tum_est.txt", alignment: Sim3, options: (5.0, Frames, All, false), part: Translation, rmse: 0.009316310190878434, mean: 0.008139053096077415, median: 0.006899402457121368, std: 0.004533150148836681, max: 0.026780576685496674, n: 81 },
    Rpe { gt: "tum_gt.txt", est: "tum_est.txt", alignment: Sim3, options: (1.0, Meters, All, false), part: Translation, rmse: 0.005674000140887281, mean: 0.00502812661566767, median: 0.004487405487912922, std: 0.0026291101794339617, max: 0.012971742583261092, n: 72 },
    Rpe { gt: "tum_gt.txt", est: "tum_est.txt", alignment: Sim3, options: (1.0, Meters, All, false), part: Rotation, rmse: 0.14339551104612464, mean: 0.13241190521189006, median: 0.13084303576901368, std: 0.05503962160422887, max: 0.25222131786787805, n: 72 },
];

#[rustfmt::skip]
pub(crate) const PUBLISHED_APE: &[Ape] = &[
    Ape { gt: "KITTI_00_gt.txt", est: "KITTI_00_ORB.txt", alignment: None, rmse: 7.790288882656827, mean: 7.01175040166684, median: 6.801631674560281, std: 3.3946954473076767, max: 13.45850880738189, n: 4541 },
    Ape { gt: "KITTI_00_gt.txt", est: "KITTI_00_ORB.txt", alignment: Se3, rmse: 1.3034497145650337, mean: 1.1569971285389835, median: 1.0656247695557912, std: 0.600282269396835, max: 3.587949120678975, n: 4541 },
    Ape { gt: "KITTI_00_gt.txt", est: "KITTI_00_ORB.txt", alignment: Sim3, rmse: 0.9377090736114023, mean: 0.8726926319693107, median: 0.8446910134864141, std: 0.34308290082665355, max: 2.693499863613383, n: 4541 },
    Ape { gt: "KITTI_00_gt.txt", est: "KITTI_00_SPTAM.txt", alignment: None, rmse: 9.224541737237876, mean: 8.62370355518929, median: 8.28232140962514, std: 3.2747377382409044, max: 14.911823227678537, n: 4541 },
    Ape { gt: "KITTI_00_gt.txt", est: "KITTI_00_SPTAM.txt", alignment: Se3, rmse: 3.738487907582604, mean: 3.4909766330848577, median: 3.6425846417432424, std: 1.3376748418045634, max: 7.768977406571304, n: 4541 },
    Ape { gt: "KITTI_00_gt.txt", est: "KITTI_00_SPTAM.txt", alignment: Sim3, rmse: 3.6352935643386006, mean: 3.3573057786205687, median: 3.4798637552962988, std: 1.3942227970315872, max: 7.291831027981607, n: 4541 },
    Ape { gt: "fr2_desk_groundtruth.txt", est: "fr2_desk_ORB.txt", alignment: None, rmse: 3.17399354190223, mean: 2.9496938875994747, median: 2.594642464975095, std: 1.1719816438389132, max: 5.066735062280106, n: 2174 },
    Ape { gt: "fr2_desk_groundtruth.txt", est: "fr2_desk_ORB.txt", alignment: Se3, rmse: 0.008118977562044926, mean: 0.0074917768702161495, median: 0.007414629829316952, std: 0.00312906950703932, max: 0.024299593694385276, n: 2174 },
    Ape { gt: "fr2_desk_groundtruth.txt", est: "fr2_desk_ORB.txt", alignment: Sim3, rmse: 0.006123163030157264, mean: 0.00558619731870614, median: 0.005305225075852613, std: 0.002507493770752984, max: 0.021476785562788304, n: 2174 },
    Ape { gt: "fr2_desk_groundtruth.txt", est: "fr2_desk_ORB_kf_mono.txt", alignment: None, rmse: 2.3738829047911167, mean: 2.2686993293991407, median: 2.415295317233584, std: 0.6988014012889509, max: 3.377261086167217, n: 118 },
    Ape { gt: "fr2_desk_groundtruth.txt", est: "fr2_desk_ORB_kf_mono.txt", alignment: Se3, rmse: 0.9390492628342705, mean: 0.9169908762115202, median: 0.9212130012115443, std: 0.20233944492959063, max: 1.411524442034499, n: 118 },
    Ape { gt: "fr2_desk_groundtruth.txt", est: "fr2_desk_ORB_kf_mono.txt", alignment: Sim3, rmse: 0.007729264783424068, mean: 0.007103615951625619, median: 0.007099822211333756, std: 0.003046337884097819, max: 0.015688557595242313, n: 118 },
];

#[rustfmt::skip]
pub(crate) const PUBLISHED_RPE: &[Rpe] = &[
    Rpe { gt: "KITTI_00_gt.txt", est: "KITTI_00_ORB.txt", alignment: None, options: (1.0, Frames, Consecutive, false), part: Translation, rmse: 0.02812037701739386, mean: 0.019301310981393958, median: 0.01470904343858892, std: 0.020450305572286533, max: 0.30271249059536337, n: 4540 },
    Rpe { gt: "KITTI_00_gt.txt", est: "KITTI_00_ORB.txt", alignment: None, options: (1.0, Frames, Consecutive, false), part: Rotation, rmse: 0.11497352125979224, mean: 0.05958345492311408, median: 0.04107440527533871, std: 0.09832966231153815, max: 2.196615406942415, n: 4540 },
    Rpe { gt: "KITTI_00_gt.txt", est: "KITTI_00_ORB.txt", alignment: None, options: (10.0, Frames, Consecutive, false), part: Translation, rmse: 0.19400775757968894, mean: 0.1415104948739975, median: 0.11125927424444243, std: 0.13271695385901408, max: 1.1885349127453586, n: 454 },
    Rpe { gt: "KITTI_00_gt.txt", est: "KITTI_00_ORB.txt", alignment: None, options: (10.0, Frames, All, false), part: Translation, rmse: 0.18934823038597612, mean: 0.13978226849548528, median: 0.11321949169175895, std: 0.12772497705835284, max: 1.5153832705472317, n: 4531 },
    Rpe { gt: "KITTI_00_gt.txt", est: "KITTI_00_ORB.txt", alignment: None, options: (100.0, Meters, Consecutive, false), part: Translation, rmse: 1.1939759245846355, mean: 1.054477825715355, median: 0.9214941902754695, std: 0.5600491260258809, max: 2.959637959978665, n: 36 },
    Rpe { gt: "KITTI_00_gt.txt", est: "KITTI_00_ORB.txt", alignment: None, options: (100.0, Meters, All, false), part: Translation, rmse: 1.2548299616430865, mean: 1.0146945009089312, median: 0.9003863828486766, std: 0.7382366168528658, max: 11.815064774902076, n: 4457 },
    Rpe { gt: "KITTI_00_gt.txt", est: "KITTI_00_ORB.txt", alignment: None, options: (100.0, Meters, All, false), part: Rotation, rmse: 0.8969429007336782, mean: 0.6300025341098227, median: 0.5346641377203215, std: 0.638438230521753, max: 7.228795125910481, n: 4457 },
    Rpe { gt: "KITTI_00_gt.txt", est: "KITTI_00_ORB.txt", alignment: Sim3, options: (100.0, Meters, All, true), part: Translation, rmse: 1.1875095069423947, mean: 0.9316766455397002, median: 0.8407048187741452, std: 0.736313423233925, max: 11.895559283121761, n: 4458 },
    Rpe { gt: "KITTI_00_gt.txt", est: "KITTI_00_SPTAM.txt", alignment: None, options: (1.0, Frames, Consecutive, false), part: Translation, rmse: 0.03491936757324089, mean: 0.023406450624852342, median: 0.01915993677265607, std: 0.025913322844850623, max: 1.136073589515664, n: 4540 },
    Rpe { gt: "KITTI_00_gt.txt", est: "KITTI_00_SPTAM.txt", alignment: None, options: (1.0, Frames, Consecutive, false), part: Rotation, rmse: 0.2963898432455661, mean: 0.2417164051134944, median: 0.20101844220773088, std: 0.1715229392184623, max: 2.503555191882532, n: 4540 },
    Rpe { gt: "KITTI_00_gt.txt", est: "KITTI_00_SPTAM.txt", alignment: None, options: (10.0, Frames, Consecutive, false), part: Translation, rmse: 0.23794204940055172, mean: 0.19038411080265236, median: 0.16657525218346417, std: 0.14272459222859243, max: 1.3940424406419616, n: 454 },
    Rpe { gt: "KITTI_00_gt.txt", est: "KITTI_00_SPTAM.txt", alignment: None, options: (10.0, Frames, All, false), part: Translation, rmse: 0.22787323053765235, mean: 0.18507273611959832, median: 0.1632315036440561, std: 0.13294469354160612, max: 1.7051778507315425, n: 4531 },
    Rpe { gt: "KITTI_00_gt.txt", est: "KITTI_00_SPTAM.txt", alignment: None, options: (100.0, Meters, Consecutive, false), part: Translation, rmse: 2.6114856788807708, mean: 2.1758875613326394, median: 1.6696166449496115, std: 1.444081289760815, max: 6.8496393099308674, n: 37 },
    Rpe { gt: "KITTI_00_gt.txt", est: "KITTI_00_SPTAM.txt", alignment: None, options: (100.0, Meters, All, false), part: Translation, rmse: 2.714585998251639, mean: 2.1620066955850157, median: 1.69102756686517, std: 1.6415554179342868, max: 16.410085267348325, n: 4457 },
    Rpe { gt: "KITTI_00_gt.txt", est: "KITTI_00_SPTAM.txt", alignment: None, options: (100.0, Meters, All, false), part: Rotation, rmse: 2.051660175081835, mean: 1.4830441604432703, median: 0.9156703587821159, std: 1.4177057142411258, max: 10.4771852248464, n: 4457 },
    Rpe { gt: "KITTI_00_gt.txt", est: "KITTI_00_SPTAM.txt", alignment: Sim3, options: (100.0, Meters, All, true), part: Translation, rmse: 2.759499496574214, mean: 2.204814260802463, median: 1.7523357200386647, std: 1.6594069865332708, max: 16.701692989101105, n: 4458 },
    Rpe { gt: "fr2_desk_groundtruth.txt", est: "fr2_desk_ORB.txt", alignment: None, options: (1.0, Frames, Consecutive, false), part: Translation, rmse: 0.003490321374787292, mean: 0.0030380874175009644, median: 0.002750288386204023, std: 0.0017182456584898963, max: 0.01948467892016712, n: 2173 },
    Rpe { gt: "fr2_desk_groundtruth.txt", est: "fr2_desk_ORB.txt", alignment: None, options: (1.0, Frames, Consecutive, false), part: Rotation, rmse: 0.2805192262673266, mean: 0.22955611958091907, median: 0.18781845711906164, std: 0.16122972513953612, max: 1.25940350270801, n: 2173 },
    Rpe { gt: "fr2_desk_groundtruth.txt", est: "fr2_desk_ORB.txt", alignment: Sim3, options: (1.0, Frames, Consecutive, false), part: Translation, rmse: 0.003485016890888191, mean: 0.0030303829997872993, median: 0.0027455208712613816, std: 0.001721081521711311, max: 0.0209077439408734, n: 2173 },
    Rpe { gt: "fr2_desk_groundtruth.txt", est: "fr2_desk_ORB.txt", alignment: None, options: (30.0, Frames, All, false), part: Translation, rmse: 0.0077019771816806545, mean: 0.006862001441520158, median: 0.006444631037533628, std: 0.0034976261555095833, max: 0.03259796844079826, n: 2144 },
    Rpe { gt: "fr2_desk_groundtruth.txt", est: "fr2_desk_ORB.txt", alignment: None, options: (0.5, Meters, Consecutive, false), part: Translation, rmse: 0.009616655960823964, mean: 0.008863159661866016, median: 0.008039738466526444, std: 0.003731550974745246, max: 0.018428929307796767, n: 36 },
    Rpe { gt: "fr2_desk_groundtruth.txt", est: "fr2_desk_ORB.txt", alignment: Sim3, options: (1.0, Meters, All, false), part: Translation, rmse: 0.011526859534470997, mean: 0.010582289365050162, median: 0.010225691113751819, std: 0.0045698624182540955, max: 0.03095421799940269, n: 1933 },
    Rpe { gt: "fr2_desk_groundtruth.txt", est: "fr2_desk_ORB.txt", alignment: Sim3, options: (1.0, Meters, All, false), part: Rotation, rmse: 0.5976502567129104, mean: 0.5423633658985735, median: 0.5068513824353541, std: 0.25105339806538746, max: 1.9463543976685271, n: 1933 },
    Rpe { gt: "fr2_desk_groundtruth.txt", est: "fr2_desk_ORB_kf_mono.txt", alignment: None, options: (1.0, Frames, Consecutive, false), part: Translation, rmse: 0.1367255573165919, mean: 0.07357971579776804, median: 0.040577855022994894, std: 0.1152384633993891, max: 1.1224424236537909, n: 117 },
    Rpe { gt: "fr2_desk_groundtruth.txt", est: "fr2_desk_ORB_kf_mono.txt", alignment: None, options: (1.0, Frames, Consecutive, false), part: Rotation, rmse: 0.3870913832499095, mean: 0.3376421803522739, median: 0.3039588717599411, std: 0.18930794234075574, max: 0.9831285704635849, n: 117 },
    Rpe { gt: "fr2_desk_groundtruth.txt", est: "fr2_desk_ORB_kf_mono.txt", alignment: Sim3, options: (1.0, Frames, Consecutive, false), part: Translation, rmse: 0.007069324681400337, mean: 0.005698826112083059, median: 0.0049311943208374415, std: 0.004183148622185956, max: 0.03590258375153949, n: 117 },
    Rpe { gt: "fr2_desk_groundtruth.txt", est: "fr2_desk_ORB_kf_mono.txt", alignment: None, options: (30.0, Frames, All, false), part: Translation, rmse: 1.3903340882199064, mean: 1.3215220169206952, median: 1.1761668446208606, std: 0.43198198534213966, max: 2.2499345063765634, n: 88 },
    Rpe { gt: "fr2_desk_groundtruth.txt", est: "fr2_desk_ORB_kf_mono.txt", alignment: None, options: (0.5, Meters, Consecutive, false), part: Translation, rmse: 0.6233349963297471, mean: 0.595237146450603, median: 0.5884355633951991, std: 0.1850385287845459, max: 1.1224424236537909, n: 11 },
    Rpe { gt: "fr2_desk_groundtruth.txt", est: "fr2_desk_ORB_kf_mono.txt", alignment: Sim3, options: (1.0, Meters, All, false), part: Translation, rmse: 0.01486975840045269, mean: 0.013862319394624218, median: 0.014001945945214814, std: 0.005380131586611857, max: 0.026837409229630252, n: 82 },
    Rpe { gt: "fr2_desk_groundtruth.txt", est: "fr2_desk_ORB_kf_mono.txt", alignment: Sim3, options: (1.0, Meters, All, false), part: Rotation, rmse: 0.5744425472797259, mean: 0.5330105493749023, median: 0.486943822367502, std: 0.2142054956817984, max: 1.16017582840884, n: 82 },
];
