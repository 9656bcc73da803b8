#include "sensors/register.h"

#include "sensors/camera/camera.h"
#include "sensors/camera/range_calibration.h"
#include "sensors/camera/target_points.h"
#include "sensors/camera/vision_line.h"
#include "sensors/features/feature_log.h"
#include "sensors/features/features_transform.h"
#include "sensors/features/fixate.h"
#include "sensors/features/wall_from_segments.h"
#include "sensors/formula/expression.h"
#include "sensors/formula/linear.h"
#include "sensors/fusion/average.h"
#include "sensors/fusion/consistency.h"
#include "sensors/fusion/covariance_intersection.h"
#include "sensors/fusion/fuse.h"
#include "sensors/laser/acquire/laser_correction.h"
#include "sensors/laser/acquire/laser_log.h"
#include "sensors/laser/features/laser_features.h"
#include "sensors/laser/segment/breakpoints.h"
#include "sensors/laser/segment/cuba.h"
#include "sensors/laser/segment/curvature_scale_space.h"
#include "sensors/laser/segment/hough.h"
#include "sensors/laser/segment/iterative_end_point_fit.h"
#include "sensors/laser/segment/maximum_likelihood_segments.h"
#include "sensors/laser/segment/split_and_merge.h"
#include "sensors/laser/segment/split_and_merge_fuzzy.h"
#include "sensors/laser/segment/triangle_area.h"
#include "sensors/laser/simulate/laser_scene.h"
#include "sensors/laser/simulate/laser_scene_features.h"
#include "sensors/laser/simulate/laser_scene_segments.h"
#include "sensors/lep/lep_detector.h"
#include "sensors/lep/lep_ranging.h"
#include "sensors/lep/lep_sensor.h"
#include "sensors/lep/lep_triangulation.h"
#include "sensors/range/ekf_line_extractor.h"
#include "sensors/range/line_extractor.h"
#include "sensors/range/range_readings.h"
#include "sensors/scene/scene_wall.h"
#include "sensors/sonar/sonar.h"
#include "sensors/wall/planar_transform.h"
#include "sensors/wall/wall_pose.h"
#include "sensors/wall/wedge_sonar_line.h"

namespace ilss {

void register_sensors(Registry& registry) {
  registry.add<Average>();
  registry.add<Breakpoints>();
  registry.add<Camera>();
  registry.add<ConsistencyModule>();
  registry.add<CovarianceIntersection>();
  registry.add<Segmenter<Cuba>>();
  registry.add<Segmenter<CurvatureScaleSpace>>();
  registry.add<EkfLineExtractor>();
  registry.add<FeatureLog>();
  registry.add<FeaturesTransform>();
  registry.add<Fixate>();
  registry.add<Fuse>();
  registry.add(expression_type());
  registry.add<Segmenter<Hough>>();
  registry.add<Segmenter<IterativeEndPointFit>>();
  registry.add<LaserCorrection>();
  registry.add<LaserFeatures>();
  registry.add<LaserLog>();
  registry.add<LaserScene>();
  registry.add<LaserSceneFeatures>();
  registry.add<LaserSceneSegments>();
  registry.add<LepRanging>();
  registry.add<LepSensor>();
  registry.add<LineExtractor>();
  registry.add<LepDetector>();
  registry.add<LepTriangulation>();
  registry.add(linear_type());
  registry.add<Segmenter<MaximumLikelihoodSegments>>();
  registry.add<PlanarTransform>();
  registry.add<RangeCalibration>();
  registry.add<RangeReadings>();
  registry.add<SceneWall>();
  registry.add<Sonar>();
  registry.add<Segmenter<SplitAndMerge>>();
  registry.add<Segmenter<SplitAndMergeFuzzy>>();
  registry.add<TargetPoints>();
  registry.add<Segmenter<TriangleArea>>();
  registry.add<VisionLine>();
  registry.add<WallFromSegments>();
  registry.add<WallPoseModule>();
  registry.add<WedgeSonarLine>();
}

}  // namespace ilss
