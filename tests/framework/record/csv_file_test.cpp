// Recordings as CSV: cells, headers and what is wrong with a file.
#include "framework/record/csv_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>

namespace ilss {
namespace {

class CsvFileTest : public ::testing::Test {
 protected:
  CsvFileTest() {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    path_ = std::filesystem::path(::testing::TempDir()) / (std::string(test->name()) + ".csv");
  }
  ~CsvFileTest() override { std::filesystem::remove(path_); }

  Outcome<std::shared_ptr<const CsvFile>> open(std::string_view text) {
    std::ofstream(path_, std::ios::binary) << text;
    return CsvFile::open(path_);
  }

  std::shared_ptr<const CsvFile> file_with(std::string_view text) {
    auto file = open(text);
    if (file) return *file;
    throw std::runtime_error(file.fault().message);
  }

  /// Why a file with this text is not opened; the path shows as FILE.
  std::string loss_of(std::string_view text) { return message_of(open(text)); }

  template <typename T>
  std::string message_of(const Outcome<T>& outcome, FaultKind kind = FaultKind::device_lost) {
    if (!outcome.is_fault()) return "no fault";
    EXPECT_EQ(fault_name(outcome.fault().kind), fault_name(kind));
    std::string message = outcome.fault().message;
    const std::size_t at = message.find(path_.string());
    return at == std::string::npos ? message : message.replace(at, path_.string().size(), "FILE");
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

TEST_F(CsvFileTest, ListsItsColumnsAndSuggestsOneForANameThatIsNearlyRight) {
  EXPECT_EQ(message_of(file_with("front,left\n1,2\n")->find_column("frnt")),
            "'FILE' has no column 'frnt' (its columns: front, left); did you mean 'front'?");
}

TEST_F(CsvFileTest, HasNoColumnBeyondItsHeader) {
  const auto file = file_with("front,left\n1,2,3\n");
  EXPECT_EQ(message_of(file->find_column("3")),
            "'FILE' has no column '3' (its columns: front, left)");
  EXPECT_TRUE(file->find_column("0").is_fault());
}

TEST_F(CsvFileTest, WithoutHeaderHasOnlyTheNumbersOfItsFirstRow) {
  const auto file = file_with("1,2\n3,4,5\n");
  for (const char* name : {"front", "3", "0"})
    EXPECT_EQ(message_of(file->find_column(name)),
              std::string("'FILE' has no column '") + name +
                  "': without a header its columns have no names, only the numbers 1 to 2");
}

TEST_F(CsvFileTest, CutsTheListOfVeryManyColumnsShort) {
  std::string header = "c0";
  for (int i = 1; i < 60; ++i) header += ",c" + std::to_string(i);
  const std::string message = message_of(file_with(header + "\n1\n")->find_column("missing"));
  EXPECT_NE(message.find("c48, c49 and 10 more)"), std::string::npos) << message;
}

TEST_F(CsvFileTest, HasNoDetectionInAnEmptyCell) {
  const auto file = file_with("1,,3\n4,\"\",\n");
  ASSERT_EQ(file->rows(), 2u) << "an empty cell makes no header";
  EXPECT_EQ(message_of(file->number(0, 1), FaultKind::no_detection),
            "FILE:1: no echo: column 2 is empty");
  EXPECT_EQ(message_of(file->number(1, 1), FaultKind::no_detection),
            "FILE:2: no echo: column 2 is empty");
  EXPECT_EQ(message_of(file->number(1, 2), FaultKind::no_detection),
            "FILE:2: no echo: column 3 is empty");
}

TEST_F(CsvFileTest, ReadsPastAByteOrderMark) {
  const auto file = file_with(
      "\xEF\xBB\xBF"
      "front\n1\n");
  EXPECT_TRUE(file->find_column("front"));
}

TEST_F(CsvFileTest, ReadsALastLineWithoutEnd) {
  const auto file = file_with("1\n25");
  ASSERT_EQ(file->rows(), 2u);
  EXPECT_EQ(*file->number(1, 0), 25);
}

TEST_F(CsvFileTest, RefusesNumbersThatAreNotFinite) {
  const auto file = file_with("1,2\nnan,inf\n");
  EXPECT_TRUE(file->number(1, 0).is_fault());
  EXPECT_TRUE(file->number(1, 1).is_fault());
}

TEST_F(CsvFileTest, IsLostWhereItHasNoRows) {
  EXPECT_EQ(loss_of(""), "'FILE' is empty");
  EXPECT_EQ(loss_of("# nothing\n\n"), "'FILE' is empty");
  EXPECT_EQ(loss_of("front,left\n"), "'FILE' has a header, but no rows");
}

TEST_F(CsvFileTest, IsLostWhereSemicolonsSeparateItsColumns) {
  const std::string expected = "the columns of 'FILE' are separated by ';'; expected ','";
  EXPECT_EQ(loss_of("front;left\n1;2\n"), expected);
  EXPECT_EQ(loss_of("1;2\n3;4\n"), expected);
}

TEST_F(CsvFileTest, IsLostWhereALineIsLongerThanAMegabyte) {
  const std::string longest(std::size_t{1} << 20, '7');
  EXPECT_TRUE(open("1\n#" + longest.substr(1) + "\n2\n"));
  EXPECT_TRUE(open("1\n#" + longest.substr(1)));
  EXPECT_EQ(loss_of("1\n#" + longest + "\n2\n"),
            "FILE:2: the line is longer than 1 MB; is this a CSV file?");
}

TEST_F(CsvFileTest, IsSharedByAllWhoReadItAtOnce) {
  const auto file = file_with("1\n");
  EXPECT_EQ(*CsvFile::open(path_), file);
}

TEST_F(CsvFileTest, IsReadAnewOnceNobodyHoldsIt) {
  file_with("1\n");
  const auto file = file_with("1\n2\n");
  EXPECT_EQ(file->rows(), 2u);
}

TEST_F(CsvFileTest, IsLostWhereItIsBinary) {
  EXPECT_EQ(loss_of(std::string("\x7F"
                                "ELF\0\n1\n",
                                8)),
            "'FILE' holds binary data; expected CSV text");
}

TEST_F(CsvFileTest, ShowsABadCellSoThatTerminalsAndJsonTakeIt) {
  const auto file = file_with("1\n\xFE\x1B[31m\n" + std::string(50, 'x') + "\n");
  EXPECT_EQ(message_of(file->number(1, 0), FaultKind::bad_data),
            "FILE:2: expected a number in column 1, got '?\?[31m'");
  EXPECT_EQ(message_of(file->number(2, 0), FaultKind::bad_data),
            "FILE:3: expected a number in column 1, got '" + std::string(40, 'x') + "...'");
}

TEST_F(CsvFileTest, IsLostWhereItCannotBeRead) {
  EXPECT_EQ(message_of(CsvFile::open(path_)), "cannot read 'FILE': No such file or directory");
  std::filesystem::create_symlink(path_, path_);
  EXPECT_EQ(message_of(CsvFile::open(path_)),
            "cannot read 'FILE': Too many levels of symbolic links");
}

TEST(CsvFile, IsLostWhereReadingFails) {
  const char* unmapped = "/proc/self/mem";  // address 0, where nothing can be read
  const auto file = CsvFile::open(unmapped);
  ASSERT_TRUE(file.is_fault());
  EXPECT_EQ(file.fault().kind, FaultKind::device_lost);
  EXPECT_EQ(file.fault().message, "cannot read '/proc/self/mem': Input/output error");
}

TEST_F(CsvFileTest, IsLostWhereItIsNoRegularFile) {
  const std::string expected = "'FILE' is not a regular file";
  std::filesystem::create_directory(path_);
  EXPECT_EQ(message_of(CsvFile::open(path_)), expected);
  std::filesystem::remove(path_);
  ASSERT_EQ(mkfifo(path_.c_str(), 0600), 0);
  EXPECT_EQ(message_of(CsvFile::open(path_)), expected) << "and opening it does not block";
}

}  // namespace
}  // namespace ilss
