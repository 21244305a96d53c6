#pragma once

#include <cstdint>
#include <span>

#include "common/util/stage_times.hpp"
#include "voxelserver/make/voxelize/points/settings.hpp"

namespace terravox::voxelize {

struct Land;

/// A set of parts of a Land, one bit for each.
using Parts = std::uint32_t;
namespace part {
inline constexpr Parts kWater = 1 << 0;
inline constexpr Parts kDecks = 1 << 1;
inline constexpr Parts kCoverage = 1 << 2;
inline constexpr Parts kGround = 1 << 3;
inline constexpr Parts kRoofs = 1 << 4;
inline constexpr Parts kCrowns = 1 << 5;
inline constexpr Parts kAppearances = 1 << 6;
inline constexpr Parts kSurface = 1 << 7;
inline constexpr Parts kRuns = 1 << 8;
inline constexpr Parts kBoxes = 1 << 9;
inline constexpr Parts kBuildings = 1 << 10;
inline constexpr Parts kNumbers = 1 << 11;
}  // namespace part

/// One step on the way from columns to boxes.
struct Step {
    StepSwitch about;  ///< name, and the setting that switches it
    Parts reads;       ///< parts that earlier steps have made
    Parts makes;       ///< parts that it makes, or changes
    void (*run)(Land&);
    /// Makes the same parts where the step is switched off; nullptr = it always runs.
    void (*otherwise)(Land&) = nullptr;
    /// Whether it reports its time itself, as what it makes is kept for several patches.
    bool reports_time = false;
};

/// All steps, in the order in which they run; each is a row of step_table.cpp.
[[nodiscard]] std::span<const Step> steps() noexcept;

/// Whether every step reads only parts that a step before it makes.
[[nodiscard]] constexpr bool in_order(std::span<const Step> table) noexcept {
    Parts made = 0;
    for (const Step& step : table) {
        if ((step.reads & ~made) != 0)
            return false;
        made |= step.makes;
    }
    return true;
}

/// Runs, in their order, the steps that make the wanted parts and all parts that these are made
/// from. Steps that have run on this land are not run again.
/// @param times receives the time of each step under its name
void run_steps(Land& land, Parts wanted, util::StageTimes& times);

}  // namespace terravox::voxelize
