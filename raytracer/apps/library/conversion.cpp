#include <terravox/world.hpp>

#include <filesystem>

#include "common/voxel/material.hpp"
#include "raytracer/apps/library/guarded.hpp"
#include "raytracer/apps/library/state.hpp"
#include "raytracer/core/material/appearance.hpp"
#include "voxelserver/out/export/formats/formats.hpp"

namespace terravox {

ConvertReport World::convert(const std::string& out, const ConvertOptions& options,
                             const Control& control) const {
    return guarded(control, [&] {
        const WorldCall call(*m_state, options.threads);
        const std::filesystem::path target(out);
        const exports::Format& format = exports::find_format_by(options.format, target);
        exports::WriteOptions write;
        write.overwrite = options.overwrite;
        format.check_target(target, write);
        const exports::Part part{options.level, m_state->block_over(options.area, options.level)};
        const voxel::Palette palette = voxel::load_palette(material::find_materials(""));
        exports::Meter meter("convert", format.steps(part, m_state->world->info()), true,
                             control.progress);
        exports::Job job(*m_state->world, part, target, palette, meter);
        job.threads = options.threads;
        job.stop = control.stop;
        format.write(job, write);
        ConvertReport report;
        for (const std::filesystem::path& file : job.files())
            report.files.push_back(file.string());
        report.voxels = job.voxels();
        report.holes = call.checked(job.holes().size());
        return report;
    });
}

}  // namespace terravox
