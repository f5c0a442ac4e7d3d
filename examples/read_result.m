function read_result(path)
% Prints how far each model of a result file is from the reference, and where it is furthest. MATLAB and GNU Octave.
%
%     octave-cli --path examples --eval "read_result('results/runs/liver_healthy/palpation.h5')"
%
% Both give arrays with their axes in reverse: what the schema calls (N, 3) is 3 x N here.
  if exist('OCTAVE_VERSION', 'builtin')
    file = load('-hdf5', path);
    points = file.mesh.points;
    models = fieldnames(file.comparisons)';
    read_error = @(model) file.comparisons.(model).error;
  else
    points = h5read(path, '/mesh/points');
    comparisons = h5info(path, '/comparisons');
    groups = {comparisons.Groups.Name};
    models = cellfun(@(group) group(numel('/comparisons/') + 1:end), groups, 'UniformOutput', false);
    read_error = @(model) h5read(path, ['/comparisons/' model '/error']);
  end
  fprintf('%d nodes\n', size(points, 2));
  for m = 1:numel(models)
    try
      off = sqrt(sum(read_error(models{m}) .^ 2, 1));
    catch
      continue  % it did not come to an end
    end
    if ~all(isfinite(off))
      fprintf('%s: diverged\n', models{m});
      continue
    end
    [largest, node] = max(off);
    fprintf('%s: at most %.3f mm off the reference, at (%.1f, %.1f, %.1f) mm\n', models{m}, 1e3 * largest, ...
            1e3 * points(:, node));
  end
end
