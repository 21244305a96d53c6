#include "voxelserver/out/country/sample.hpp"

#include <algorithm>
#include <cmath>

#include "common/util/error.hpp"
#include "voxelserver/out/country/task.hpp"
#include "voxelserver/out/export/archive/archive_export.hpp"

namespace terravox::country {
namespace {

std::int32_t middle_patch(std::int32_t min, std::int32_t max) noexcept {
    return voxel::floor_div(min + (max - min) / 2, grid::kPatchSize);
}

double count_points(const Survey& survey, const exports::Columns::At& column) {
    double sum = 0;
    for (const std::size_t i : survey.read_by(column))
        sum += static_cast<double>(survey.squares()[i].points);
    return sum;
}

std::vector<voxelize::SquareState> list_states(const voxelize::LidarWorld& world) {
    std::vector<voxelize::SquareState> out;
    for (const voxelize::SquareInfo& square : world.squares())
        out.push_back(square.state);
    return out;
}

/// Measures one column after the other.
class Sampler {
public:
    Sampler(voxelize::LidarWorld& world, exports::Job& job, const Survey& survey)
        : m_world(world), m_job(job), m_survey(survey) {}

    void measure(const exports::Columns::At& column) {
        for (const std::size_t i : m_survey.read_by(column))
            decode(i);
        const auto before = list_states(m_world);
        const double start = used_cpu_s();
        const exports::MadeColumn made = exports::make_archive_column(m_job, column);
        double used = used_cpu_s() - start;
        // Water that reaches far may have needed squares that are none of its neighbours.
        const auto after = list_states(m_world);
        for (std::size_t i = 0; i < after.size(); ++i)
            if (before[i] == voxelize::SquareState::kFetched && after[i] != before[i])
                used -= rate() * static_cast<double>(m_survey.squares()[i].points);
        m_sample.made.push_back(
            {m_survey.covered(column), std::max(used, 0.0), static_cast<double>(made.bytes)});
    }

    Sample finish() {
        m_sample.peak_mib = used_peak_mib();
        for (const voxelize::SquareInfo& square : m_world.squares())
            if (square.state == voxelize::SquareState::kFailed)
                m_sample.damaged.push_back({square.name, square.error});
        return std::move(m_sample);
    }

private:
    void decode(std::size_t i) {
        const voxelize::SquareInfo square = m_world.squares()[i];
        if (square.state != voxelize::SquareState::kFetched)
            return;
        const double start = used_cpu_s();
        try {
            // Any query of the ground in a square's middle loads its points.
            (void)m_world.ground_heights(middle_patch(square.bounds.min_x, square.bounds.max_x),
                                         middle_patch(square.bounds.min_z, square.bounds.max_z));
        } catch (const util::Error&) {
            return;  // its state says so
        }
        m_sample.decoded.push_back({static_cast<double>(square.points), used_cpu_s() - start, 0});
    }

    /// Seconds a point, so far.
    [[nodiscard]] double rate() const {
        double points = 0;
        double seconds = 0;
        for (const SampledCost& square : m_sample.decoded) {
            points += square.size;
            seconds += square.cpu_s;
        }
        return points > 0 ? seconds / points : 0;
    }

    voxelize::LidarWorld& m_world;
    exports::Job& m_job;
    const Survey& m_survey;
    Sample m_sample;
};

}  // namespace

std::vector<std::size_t> columns_to_sample(const Survey& survey, const exports::Columns& columns,
                                           std::size_t count) {
    constexpr std::size_t kCandidates = 8;
    std::vector<std::size_t> out;
    count = std::min(count, columns.count());
    for (std::size_t k = 0; k < count; ++k) {
        const std::size_t first = columns.count() * k / count;
        const std::size_t end = columns.count() * (k + 1) / count;
        // The places within the stretches differ, or all might lie at one edge of the country.
        constexpr double kGoldenRatio = 0.6180339887498949;
        const double shift = std::fmod(0.5 + static_cast<double>(k) * kGoldenRatio, 1);
        const double width = static_cast<double>(end - first);
        const std::size_t begin = first + static_cast<std::size_t>(shift * width);
        std::size_t best = begin;
        for (std::size_t i = begin; i < std::min(end, begin + kCandidates); ++i)
            if (count_points(survey, columns.at(i)) < count_points(survey, columns.at(best)) &&
                survey.covered(columns.at(i)) > 0)
                best = i;
        out.push_back(best);
    }
    return out;
}

Sample take_sample(voxelize::LidarWorld& world, exports::Job& job, const Survey& survey,
                   const exports::Columns& columns, const std::vector<std::size_t>& chosen,
                   const std::function<void()>& progress) {
    Sampler sampler(world, job, survey);
    for (const std::size_t i : chosen) {
        sampler.measure(columns.at(i));
        if (progress)
            progress();
    }
    return sampler.finish();
}

namespace {

std::vector<SizeAndValue> list_cpu(const std::vector<SampledCost>& costs) {
    std::vector<SizeAndValue> out;
    for (const SampledCost& cost : costs)
        out.push_back({cost.size, cost.cpu_s});
    return out;
}

std::vector<SizeAndValue> measure_bytes(const std::vector<SampledCost>& costs) {
    std::vector<SizeAndValue> out;
    for (const SampledCost& cost : costs)
        out.push_back({cost.size, cost.bytes});
    return out;
}

/// Costs of one unit.
struct Rates {
    Measured decode;  ///< seconds a point
    Measured make;    ///< seconds a column of voxels
    double open_s = 0;

    [[nodiscard]] Measured of(const Workload& work, std::size_t tasks) const {
        const double cpu_s = open_s * static_cast<double>(tasks) + decode.value * work.points +
                             make.value * work.covered;
        return {cpu_s, std::hypot(decode.error * work.points, make.error * work.covered)};
    }
};

Rates measure_rates(const Sample& sample, double squares, double columns) {
    return {measure_ratio(list_cpu(sample.decoded), squares),
            measure_ratio(list_cpu(sample.made), columns), sample.open_cpu_s};
}

}  // namespace

Measured measure_ratio(const std::vector<SizeAndValue>& measured, double population) {
    const auto count = static_cast<double>(measured.size());
    double size = 0;
    double value = 0;
    for (const SizeAndValue& m : measured) {
        size += m.size;
        value += m.value;
    }
    if (size <= 0)
        return {};
    const double ratio = value / size;
    // One measurement says nothing of how others differ from it.
    if (measured.size() < 2)
        return {ratio, population > count ? ratio : 0};
    double squares = 0;
    for (const SizeAndValue& m : measured)
        squares += (m.value - ratio * m.size) * (m.value - ratio * m.size);
    const double left = population > count ? 1 - count / population : 0;
    const double mean = size / count;
    const double variance = left * squares / (count - 1) / count / (mean * mean);
    constexpr double kErrors = 2;  // standard errors: about 95 %
    return {ratio, kErrors * std::sqrt(variance)};
}

Estimate make_estimate(const Sample& sample, const std::vector<Workload>& shards,
                       const Workload& together, std::uint64_t squares) {
    Workload alone;
    for (const Workload& shard : shards) {
        alone.points += shard.points;
        alone.covered += shard.covered;
    }
    const auto columns = static_cast<double>(together.columns);
    const Rates rates = measure_rates(sample, static_cast<double>(squares), columns);
    Estimate out;
    out.sampled_columns = sample.made.size();
    out.cpu_s = rates.of(alone, shards.size());
    out.one_machine_cpu_s = rates.of(together, shards.size());
    out.memory_mib = sample.peak_mib;
    const Measured bytes = measure_ratio(measure_bytes(sample.made), columns);
    out.output_bytes = {bytes.value * together.covered, bytes.error * together.covered};
    return out;
}

PlannedShard planned(const Sample& sample, const Workload& shard, std::uint64_t rows) {
    return {shard.columns, shard.columns * rows, shard.squares,
            measure_rates(sample, 0, 0).of(shard, 1).value, shard.scratch_bytes};
}

}  // namespace terravox::country
