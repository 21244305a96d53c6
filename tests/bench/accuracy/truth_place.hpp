#pragma once

#include <filesystem>
#include <vector>

#include "tests/bench/accuracy/area.hpp"
#include "tests/bench/accuracy/tree_tops.hpp"
#include "voxelserver/tools/survey/survey.hpp"
#include "voxelserver/tools/survey/truth.hpp"

namespace terravox::bench {

/// The survey that accuracy is measured on: four squares of 1 km that meet in the middle of the
/// place, so that their edges cross its lake, village, river and castle hill. 8 pulses on a square
/// metre. @param folder where its files go or are
[[nodiscard]] survey::SurveyOptions accuracy_survey(const std::filesystem::path& folder,
                                                    int threads);

/// The truth of a survey: the data of its generator, column by column and thing by thing.
struct TruthPlace {
    explicit TruthPlace(const survey::SurveyOptions& options, int threads);

    Area area;
    survey::SquareModel model;  ///< of the whole area: squares agree to the bit
    std::vector<survey::TrueColumn> columns;

    [[nodiscard]] survey::Vec2 centre(std::size_t index) const noexcept;  ///< place frame
    /// The column that holds a point of the place frame, or -1 outside the area.
    [[nodiscard]] std::ptrdiff_t find_column(survey::Vec2 p) const noexcept;
    /// Trees with their trunk in the area.
    [[nodiscard]] std::vector<TreeTop> trees() const;
};

}  // namespace terravox::bench
