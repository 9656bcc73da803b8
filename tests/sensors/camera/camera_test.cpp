#include "sensors/camera/camera.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <numeric>
#include <opencv2/imgcodecs.hpp>

#include "tests/sensors/camera/camera_rig.h"

namespace ilss {
namespace {

/// A folder that goes when the test ends.
class CameraFiles : public ::testing::Test {
 protected:
  CameraFiles()
      : folder_(std::filesystem::temp_directory_path() /
                ("ilss_camera_" + std::to_string(getpid()))) {
    std::filesystem::create_directories(folder_);
  }
  ~CameraFiles() override { std::filesystem::remove_all(folder_); }

  void write_image(const std::string& file_name, int rows, int columns, int level) {
    ASSERT_TRUE(cv::imwrite((folder_ / file_name).string(),
                            cv::Mat(rows, columns, CV_8UC1, cv::Scalar(level))));
  }
  static Camera::Options options_for(std::vector<std::filesystem::path> images) {
    Camera::Options options;
    options.input.images = std::move(images);
    options.rows = 6;
    options.columns = 8;
    return options;
  }
  static FaultKind fault_of(Camera& camera) {
    CameraRig rig;
    Output image;
    const auto outcome = run(camera, rig.parameters, nullptr, 1, image);
    EXPECT_TRUE(outcome.is_fault());
    return outcome.is_fault() ? outcome.fault().kind : FaultKind::internal;
  }

  std::filesystem::path folder_;
};

TEST_F(CameraFiles, FolderIsReadInOrderOfNameAndThenEnds) {
  write_image("b.png", 6, 8, 20);
  write_image("a.png", 6, 8, 10);
  Camera camera(options_for({folder_}));
  CameraRig rig;
  for (const int level : {10, 20}) {
    Output image;
    ASSERT_TRUE(run(camera, rig.parameters, nullptr, 1, image));
    EXPECT_EQ(image.samples.shape, (std::vector<std::size_t>{6, 8}));
    EXPECT_EQ(image.samples.bytes, std::vector(48, static_cast<std::byte>(level)));
  }
  EXPECT_EQ(fault_of(camera), FaultKind::end_of_data);
  camera.reset();
  Output image;
  ASSERT_TRUE(run(camera, rig.parameters, nullptr, 1, image));
  EXPECT_EQ(levels_of(image).front(), 10);
}

TEST_F(CameraFiles, MissingFileIsALostDevice) {
  Camera camera(options_for({folder_ / "none.png"}));
  EXPECT_EQ(fault_of(camera), FaultKind::device_lost);
}

TEST_F(CameraFiles, FileThatIsNoImageIsBadDataAndTheNextIsRead) {
  std::ofstream(folder_ / "a.png") << "not an image";
  write_image("b.png", 6, 8, 20);
  Camera camera(options_for({folder_}));
  EXPECT_EQ(fault_of(camera), FaultKind::bad_data);
  CameraRig rig;
  Output image;
  EXPECT_TRUE(run(camera, rig.parameters, nullptr, 1, image));
}

TEST_F(CameraFiles, ImageOfAnotherSizeIsBadData) {
  write_image("a.png", 5, 8, 20);
  Camera camera(options_for({folder_ / "a.png"}));
  EXPECT_EQ(fault_of(camera), FaultKind::bad_data);
}

TEST_F(CameraFiles, MissingVideoAndDeviceAreLost) {
  Camera::Options video;
  video.input.video = folder_ / "none.avi";
  Camera of_video(video);
  EXPECT_EQ(fault_of(of_video), FaultKind::device_lost);
  Camera::Options device;
  device.input.device = 999;
  Camera of_device(device);
  EXPECT_EQ(fault_of(of_device), FaultKind::device_lost);
}

TEST(Camera, SameSeedGivesTheSameImageAndAnotherAnother) {
  CameraRig rig;
  rig.place(paper_poses[2]);
  Camera camera(rig.options);
  Output first, again, other;
  ASSERT_TRUE(run(camera, rig.parameters, nullptr, 5, first));
  ASSERT_TRUE(run(camera, rig.parameters, nullptr, 6, other));
  ASSERT_TRUE(run(camera, rig.parameters, nullptr, 5, again));
  EXPECT_EQ(first.samples.bytes, again.samples.bytes);
  EXPECT_NE(first.samples.bytes, other.samples.bytes);
}

TEST(Camera, MovesWithTheRobotAndItsMount) {
  // The robot turned right by what its camera is mounted to the left looks straight ahead.
  CameraRig straight, turned;
  straight.options.noise_std = turned.options.noise_std = 0;
  straight.place({1.2, 0});
  turned.place({1.2, -0.3});
  turned.parameter("mount.heading") = -0.3;
  Output from_straight, from_turned;
  Camera first(straight.options), second(turned.options);
  ASSERT_TRUE(run(first, straight.parameters, nullptr, 1, from_straight));
  ASSERT_TRUE(run(second, turned.parameters, nullptr, 1, from_turned));
  EXPECT_EQ(from_straight.samples.bytes, from_turned.samples.bytes);
}

TEST(Camera, IntrinsicsErrorsGoWithTheImageAndTheRobotsPlaceDoesNot) {
  CameraRig rig;
  rig.place({1.2, 0});
  const auto& parameters = descriptor<Camera::Parameters>();
  rig.parameters.lineage.add({4, 0, persistent_tick}, *parameters.find("k1"), 0.01);
  rig.parameters.lineage.add({5, 0, persistent_tick}, *parameters.find("robot.x"), 0.02);
  Camera camera(rig.options);
  Output image;
  ASSERT_TRUE(run(camera, rig.parameters, nullptr, 1, image));
  const Eigen::MatrixXd covariance = image.estimate.lineage.covariance();
  EXPECT_DOUBLE_EQ(covariance(4, 4), 1e-4);
  EXPECT_DOUBLE_EQ(covariance.sum(), 1e-4);
}

TEST(Camera, NoiseHasTheDeclaredSpread) {
  SCOPED_TRACE("seed 8");
  Scene scene = target_scene();
  scene.walls[0].targets.clear();
  CameraRig rig(scene);
  rig.place({1.2, 0});
  rig.options.noise_std = 3;
  Camera camera(rig.options);
  Output image;
  ASSERT_TRUE(run(camera, rig.parameters, nullptr, 8, image));
  double squares = 0;
  for (const std::uint8_t level : levels_of(image)) squares += std::pow(level - 204.0, 2);
  EXPECT_NEAR(squares / (128 * 128), 9 + 1.0 / 12, 0.4);
}

TEST(Camera, ImpossibleIntrinsicsAreAFault) {
  CameraRig rig;
  rig.place({1.2, 0});
  rig.parameter("pixel_pitch") = 0;
  Camera camera(rig.options);
  Output image;
  const auto outcome = run(camera, rig.parameters, nullptr, 1, image);
  ASSERT_TRUE(outcome.is_fault());
  EXPECT_EQ(outcome.fault().kind, FaultKind::out_of_range);
}

}  // namespace
}  // namespace ilss
