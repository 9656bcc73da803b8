// Recordings as CSV: cells, headers and what is wrong with a file.
#include "sensors/sonar/csv_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace ilss {
namespace {

class CsvFileTest : public ::testing::Test {
 protected:
  std::shared_ptr<const CsvFile> file_with(std::string_view text) {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    path_ = std::filesystem::path(::testing::TempDir()) / (std::string(test->name()) + ".csv");
    std::ofstream(path_, std::ios::binary) << text;
    auto file = CsvFile::open(path_);
    EXPECT_TRUE(file);
    return *file;
  }
  std::filesystem::path path_;
};

TEST_F(CsvFileTest, ReadsNumbersByRowAndColumn) {
  const auto file = file_with("1, 2.5\n-3e-2,4\n");
  ASSERT_EQ(file->rows(), 2u);
  EXPECT_EQ(*file->number(0, 1), 2.5);
  EXPECT_EQ(*file->number(1, 0), -0.03);
}

TEST_F(CsvFileTest, FindsColumnsByNameAndByNumberFromOne) {
  const auto file = file_with("S1,\"S2\",2\n1,2,3\n");
  EXPECT_EQ(file->rows(), 1u);
  EXPECT_EQ(*file->find_column("S2"), 1u);
  EXPECT_EQ(*file->find_column("1"), 0u);
  EXPECT_EQ(*file->find_column("2"), 2u) << "a name goes before a number";
}

TEST_F(CsvFileTest, LeavesOutCommentsAndEmptyLinesButCountsThem) {
  const auto file = file_with("# origin\r\n\r\na,b\r\n1,2\r\n\r\nx,4\r\n");
  ASSERT_EQ(file->rows(), 2u);
  EXPECT_EQ(*file->number(0, 1), 2);
  const auto bad = file->number(1, 0);
  ASSERT_TRUE(bad.is_fault());
  EXPECT_EQ(bad.fault().kind, FaultKind::bad_data);
  EXPECT_EQ(bad.fault().message, path_.string() + ":6: expected a number in column 1, got 'x'");
}

TEST_F(CsvFileTest, ReportsAShortRowWithFileAndLine) {
  const auto file = file_with("1,2\n3\n");
  const auto bad = file->number(1, 1);
  ASSERT_TRUE(bad.is_fault());
  EXPECT_EQ(bad.fault().kind, FaultKind::bad_data);
  EXPECT_EQ(bad.fault().message, path_.string() + ":2: the row has 1 columns, number 2 is wanted");
}

TEST_F(CsvFileTest, SuggestsTheNameOfAColumnThatIsNearlyRight) {
  const auto missing = file_with("front,left\n1,2\n")->find_column("frnt");
  ASSERT_TRUE(missing.is_fault());
  EXPECT_NE(missing.fault().message.find("did you mean 'front'?"), std::string::npos);
}

TEST_F(CsvFileTest, SaysThatAFileWithoutHeaderHasOnlyNumbers) {
  const auto missing = file_with("1,2\n")->find_column("front");
  ASSERT_TRUE(missing.is_fault());
  EXPECT_NE(missing.fault().message.find("no header"), std::string::npos);
}

TEST_F(CsvFileTest, RefusesNumbersThatAreNotFinite) {
  const auto file = file_with("1,2\nnan,inf\n");
  EXPECT_TRUE(file->number(1, 0).is_fault());
  EXPECT_TRUE(file->number(1, 1).is_fault());
}

TEST_F(CsvFileTest, HasNoRowsInAnEmptyFile) { EXPECT_EQ(file_with("# nothing\n")->rows(), 0u); }

TEST_F(CsvFileTest, IsSharedByAllWhoReadItAtOnce) {
  const auto file = file_with("1\n");
  EXPECT_EQ(*CsvFile::open(path_), file);
}

TEST_F(CsvFileTest, IsReadAnewOnceNobodyHoldsIt) {
  file_with("1\n");
  const auto file = file_with("1\n2\n");
  EXPECT_EQ(file->rows(), 2u);
}

TEST(CsvFile, IsLostWhereItCannotBeRead) {
  for (const char* path : {"/nonexistent/file.csv", "/tmp"}) {
    const auto file = CsvFile::open(path);
    ASSERT_TRUE(file.is_fault()) << path;
    EXPECT_EQ(file.fault().kind, FaultKind::device_lost);
    EXPECT_NE(file.fault().message.find(path), std::string::npos);
  }
}

}  // namespace
}  // namespace ilss
