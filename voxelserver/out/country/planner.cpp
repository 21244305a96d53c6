#include "voxelserver/out/country/plan.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/util/error.hpp"
#include "common/util/version.hpp"
#include "voxelserver/make/voxelize/world/input_fingerprints.hpp"
#include "voxelserver/out/country/inputs.hpp"
#include "voxelserver/out/country/sample.hpp"
#include "voxelserver/out/country/task.hpp"
#include "voxelserver/out/country/workload.hpp"
#include "voxelserver/out/export/archive/archive_export.hpp"
#include "voxelserver/out/export/core/job.hpp"

namespace terravox::country {
namespace {

class Planner {
public:
    explicit Planner(const PlanOptions& options) : m_options(options) {}

    PlannedCountry run(const std::function<void(std::size_t, std::size_t)>& progress) {
        look();
        worlds::WorldOptions world = m_plan.world;
        world.threads = m_options.world.threads;
        world.cache_dir = m_options.scratch;
        world.cache_bytes = m_options.scratch_bytes;
        const double before = used_cpu_s();
        OpenedCountry country(world, m_plan.selection());
        const double open_cpu_s = used_cpu_s() - before;
        describe(country);
        exports::Meter silent("", 0, true);
        exports::Job job(country.world(), country.part(), "the sample", country.palette(), silent);
        const exports::ArchiveColumns columns = exports::archive_columns(job);
        const Survey survey(country.squares(), columns.edge);
        const auto chosen = columns_to_sample(survey, columns.columns, m_options.sample);
        std::size_t measured = 0;
        Sample sample = take_sample(country.world(), job, survey, columns.columns, chosen, [&] {
            if (progress)
                progress(++measured, chosen.size());
        });
        sample.open_cpu_s = open_cpu_s;
        foresee(sample, survey, columns);
        std::string known = country.world().known_squares({});
        m_plan.known_squares = fingerprint_of_known(known);
        return {std::move(m_plan), std::move(known)};
    }

private:
    void look() {
        Inputs inputs = look_at_inputs(m_options.world);
        m_plan.program = kVersion;
        m_plan.box_recipe = voxelize::kBoxRecipe;
        m_plan.world = m_options.world;
        m_plan.world.left_out = std::move(inputs.left_out);
        m_plan.area = m_options.area;
        m_plan.heights = m_options.heights;
        m_plan.squares = std::move(inputs.squares);
        m_plan.images = std::move(inputs.images);
        m_plan.missing = std::move(inputs.missing);
        m_plan.scratch_bytes = m_options.scratch_bytes;
    }

    void describe(OpenedCountry& country) {
        const voxel::WorldInfo& info = country.world().info();
        m_plan.fingerprint = country.fingerprint();
        m_plan.fingerprint_of_all_boxes = country.fingerprint_of_all_boxes();
        // By the names of folders, which may be others where a task runs.
        m_plan.world.title = info.title;
        m_plan.crs = info.crs;
        m_plan.voxel_m = info.voxel_m;
        m_plan.bounds = country.part().bounds;
    }

    void foresee(const Sample& sample, const Survey& survey,
                 const exports::ArchiveColumns& columns) {
        const std::size_t all = columns.columns.count();
        const Workload together =
            measure_workload(survey, columns.columns, 0, all, m_options.scratch_bytes);
        const auto squares = survey.squares().size();
        const int shards = m_options.shards > 0
                               ? m_options.shards
                               : usual_shards(make_estimate(sample, {together}, together, squares));
        std::vector<Workload> works;
        for (int number = 1; number <= shards; ++number) {
            const auto [first, end] = exports::columns_of_shard({number, shards}, all);
            works.push_back(
                measure_workload(survey, columns.columns, first, end, m_options.scratch_bytes));
            m_plan.shards.push_back(planned(sample, works.back(), columns.rows));
        }
        m_plan.estimate = make_estimate(sample, works, together, squares);
        for (const MissingSquare& square : sample.damaged)
            m_plan.missing.push_back(square);
    }

    static int usual_shards(const Estimate& whole) {
        const double wanted = std::ceil(whole.cpu_s.value / PlanOptions::kUsualTask_s);
        return static_cast<int>(std::clamp(wanted, 1.0, static_cast<double>(kMaxShards)));
    }

    const PlanOptions& m_options;
    Plan m_plan;
};

}  // namespace

PlannedCountry make_plan(const PlanOptions& options,
                         const std::function<void(std::size_t, std::size_t)>& progress) {
    if (options.shards < 0 || options.shards > kMaxShards)
        throw util::UsageError("plan the country: --shards = " + std::to_string(options.shards) +
                               "; allowed: 1 to " + std::to_string(kMaxShards));
    return Planner(options).run(progress);
}

}  // namespace terravox::country
