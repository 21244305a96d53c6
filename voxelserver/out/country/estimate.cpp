#include <cmath>

#include "voxelserver/out/country/sample.hpp"

namespace terravox::country {
namespace {

std::vector<SizeAndValue> cpu_of(const std::vector<SampledCost>& costs) {
    std::vector<SizeAndValue> out;
    for (const SampledCost& cost : costs)
        out.push_back({cost.size, cost.cpu_s});
    return out;
}

std::vector<SizeAndValue> bytes_of(const std::vector<SampledCost>& costs) {
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

Rates rates_of(const Sample& sample, double squares, double columns) {
    return {ratio_of(cpu_of(sample.decoded), squares), ratio_of(cpu_of(sample.made), columns),
            sample.open_cpu_s};
}

}  // namespace

Measured ratio_of(const std::vector<SizeAndValue>& measured, double population) {
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

Estimate estimate_of(const Sample& sample, const std::vector<Workload>& shards,
                     const Workload& together, std::uint64_t squares) {
    Workload alone;
    for (const Workload& shard : shards) {
        alone.points += shard.points;
        alone.covered += shard.covered;
    }
    const auto columns = static_cast<double>(together.columns);
    const Rates rates = rates_of(sample, static_cast<double>(squares), columns);
    Estimate out;
    out.sampled_columns = sample.made.size();
    out.cpu_s = rates.of(alone, shards.size());
    out.one_machine_cpu_s = rates.of(together, shards.size());
    out.memory_mib = sample.peak_mib;
    const Measured bytes = ratio_of(bytes_of(sample.made), columns);
    out.output_bytes = {bytes.value * together.covered, bytes.error * together.covered};
    return out;
}

PlannedShard planned(const Sample& sample, const Workload& shard, std::uint64_t rows) {
    return {shard.columns, shard.columns * rows, shard.squares,
            rates_of(sample, 0, 0).of(shard, 1).value, shard.scratch_bytes};
}

}  // namespace terravox::country
