#include "parts/shape/internal/min_cut.h"

#include <algorithm>
#include <boost/graph/boykov_kolmogorov_max_flow.hpp>
#include <boost/graph/compressed_sparse_row_graph.hpp>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace rangegrasp::parts {
namespace {

using Graph = boost::compressed_sparse_row_graph<boost::directedS>;
using Arc = boost::graph_traits<Graph>::edge_descriptor;

// Steps of the largest capacity: finer ones than the costs are known to, and far from overflow.
constexpr double kSteps = 1e6;

}  // namespace

std::vector<bool> MinCut(std::uint32_t nodes, const std::vector<CutLink>& links,
                         std::uint32_t source, std::uint32_t sink) {
  if (source == sink || source >= nodes || sink >= nodes) {
    throw std::invalid_argument("MinCut: source and sink must be two of the nodes");
  }
  double largest = 0.0;
  for (const CutLink& link : links) largest = std::max(largest, link.capacity);
  // Arcs there and back, those of a node beside each other.
  std::vector<std::size_t> end(nodes + 1, 0);
  for (const CutLink& link : links) {
    if (link.a >= nodes || link.b >= nodes) throw std::invalid_argument("MinCut: no such node");
    ++end[link.a];
    ++end[link.b];
  }
  std::exclusive_scan(end.begin(), end.end(), end.begin(), std::size_t{0});
  std::vector<std::pair<std::uint32_t, std::uint32_t>> ends(2 * links.size());
  std::vector<std::int64_t> capacity(ends.size());
  std::vector<std::size_t> back(ends.size());
  for (const CutLink& link : links) {
    const std::size_t there = end[link.a]++;
    const std::size_t again = end[link.b]++;
    ends[there] = {link.a, link.b};
    ends[again] = {link.b, link.a};
    back[there] = again;
    back[again] = there;
    capacity[there] = capacity[again] =
        link.capacity > 0.0 ? std::llround(kSteps * link.capacity / largest) : 0;
  }
  const Graph graph(boost::edges_are_sorted, ends.begin(), ends.end(), nodes);
  std::vector<Arc> reverse(ends.size());
  for (std::size_t k = 0; k < ends.size(); ++k) reverse[k] = {ends[k].second, back[k]};

  std::vector<std::int64_t> residual(ends.size());
  std::vector<Arc> predecessor(nodes);
  std::vector<boost::default_color_type> color(nodes);
  std::vector<long> distance(nodes);
  const auto of_arc = boost::get(boost::edge_index, graph);
  const auto of_node = boost::get(boost::vertex_index, graph);
  boost::boykov_kolmogorov_max_flow(
      graph, boost::make_iterator_property_map(capacity.begin(), of_arc),
      boost::make_iterator_property_map(residual.begin(), of_arc),
      boost::make_iterator_property_map(reverse.begin(), of_arc),
      boost::make_iterator_property_map(predecessor.begin(), of_node),
      boost::make_iterator_property_map(color.begin(), of_node),
      boost::make_iterator_property_map(distance.begin(), of_node), of_node, source, sink);
  std::vector<bool> with_source(nodes);
  for (std::uint32_t v = 0; v < nodes; ++v) with_source[v] = color[v] == boost::black_color;
  return with_source;
}

}  // namespace rangegrasp::parts
