#include "voxelserver/make/voxelize/points/brightness_scales.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "common/thread/parallel.hpp"
#include "common/voxel/bytes.hpp"

namespace terravox::voxelize {
namespace {

using voxel::Fingerprint;

/// Brings the echoes of a file to voxels of the world.
void place_echoes(std::vector<GroundEcho>& echoes, const SquareSource& source,
                  const grid::Frame& frame) {
    std::vector<double> x;
    std::vector<double> y;
    for (const GroundEcho& e : echoes) {
        x.push_back(e.x);
        y.push_back(e.z);
    }
    if (source.transform && !echoes.empty())
        geo::Transform(*source.info.crs, frame.crs()).apply(x, y);
    for (std::size_t i = 0; i < echoes.size(); ++i) {
        echoes[i].x = frame.x(x[i]);
        echoes[i].z = frame.z(y[i]);
    }
}

/// Of each file what its echoes depend on.
std::vector<Fingerprint> fingerprints_of_echoes(const Sources& sources, int threads) {
    std::vector<Fingerprint> out(sources.files.size());
    const std::string frame = sources.frame.crs().wkt();
    thread::parallel_for(sources.files.size(), threads, [&](std::size_t i) {
        const SquareSource& file = sources.files[i];
        voxel::ByteWriter print;
        print.add(file.identity);
        print.add(file.side_identity);
        print.add(file.info.crs->wkt());
        for (const double v : {file.info.min[0], file.info.min[1], file.info.max[0],
                               file.info.max[1], sources.frame.voxel_m()})
            print.add(v);
        print.add(frame);
        out[i] = print.fingerprint();
    });
    return out;
}

}  // namespace

std::vector<Fingerprint> share_brightness(Sources& sources, std::vector<SquareSample>& samples,
                                          const std::vector<const KnownSquare*>& known,
                                          const ClassTable& classes,
                                          const Settings::Points& filters, int threads) {
    const std::size_t count = sources.files.size();
    std::vector<Fingerprint> scale_of(count);
    if (std::none_of(samples.begin(), samples.end(), [](const auto& s) { return s.has_echoes; }))
        return scale_of;
    std::vector<grid::ColumnRect> bounds;
    for (const SquareSource& file : sources.files)
        bounds.push_back(file.bounds);
    const std::vector<Fingerprint> echoes_of = fingerprints_of_echoes(sources, threads);
    std::vector<std::vector<std::size_t>> shares(count);
    thread::parallel_for(count, threads, [&](std::size_t i) {
        if (!samples[i].has_echoes)
            return;
        shares[i] = files_sharing_scale(i, bounds, sources.frame.voxel_m());
        voxel::ByteWriter print;
        for (const std::size_t k : shares[i])
            print.add(echoes_of[k]);
        scale_of[i] = print.fingerprint();
    });
    std::vector<std::size_t> missing;
    std::set<std::size_t> sampled;
    for (std::size_t i = 0; i < count; ++i) {
        if (!samples[i].has_echoes)
            continue;
        if (known[i] != nullptr && known[i]->scale_of == scale_of[i]) {
            sources.files[i].brightness = known[i]->brightness;
            continue;
        }
        missing.push_back(i);
        sampled.insert(shares[i].begin(), shares[i].end());
    }
    const std::vector<std::size_t> wanted(sampled.begin(), sampled.end());
    thread::parallel_for(wanted.size(), threads, [&](std::size_t n) {
        const SquareSource& file = sources.files[wanted[n]];
        SquareSample& sample = samples[wanted[n]];
        if (sample.has_echoes && sample.echoes.empty())
            sample.echoes = sampled_echoes(file, classes, filters);
        place_echoes(sample.echoes, file, sources.frame);
    });
    thread::parallel_for(missing.size(), threads, [&](std::size_t n) {
        std::vector<GroundEcho> near;
        for (const std::size_t k : shares[missing[n]])
            near.insert(near.end(), samples[k].echoes.begin(), samples[k].echoes.end());
        sources.files[missing[n]].brightness =
            voxelize::scale_of(std::move(near), sources.frame.voxel_m());
    });
    std::set<std::uint16_t> lines;
    for (const SquareSource& file : sources.files)
        for (const BrightnessScale::Line& line : file.brightness.lines())
            lines.insert(line.number);
    sources.flight_lines = lines.size();
    return scale_of;
}

}  // namespace terravox::voxelize
